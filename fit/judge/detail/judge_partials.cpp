#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "fit/judge/detail/reasons.hpp"

namespace klang::fit::detail {
namespace {

constexpr double kStrongDb = 26.0;  // below the strongest: what a person hears of the ring
constexpr double kLeftOutCents = 60.0;
constexpr double kPairCents = 3.0;
constexpr double kVisible = 0.3;  // of the loudest mode's surface motion

/// Energy of a partial's ring, amplitude^2 / (2 decay); without decays amplitude^2, without amplitudes all alike.
std::vector<double> energies(const PartialTable& table) {
  const auto all = [&](auto has) { return std::all_of(table.partials.begin(), table.partials.end(), has); };
  const bool amplitudes = all([](const Partial& p) { return p.amplitude && *p.amplitude > 0.0; });
  const bool decays = amplitudes && all([](const Partial& p) { return p.decay_per_s && *p.decay_per_s > 0.0; });
  std::vector<double> energy;
  for (const Partial& partial : table.partials)
    energy.push_back(
        !amplitudes ? 1.0 : *partial.amplitude * *partial.amplitude / (decays ? 2.0 * *partial.decay_per_s : 1.0));
  return energy;
}

std::string named(const JudgedSpecimen& specimen, const std::vector<std::size_t>& rows) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, rows.size()); ++i)
    text += (i ? ", " : "") + shown("%.6g Hz", specimen.partials.partials[rows[i]].frequency_hz);
  return text + (rows.size() > 3 ? ", ..." : "");
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a room makes of a ring: its echoes are noise with the room's decay, and a fit finds lines of about that decay in it, beside each
/// partial as far as such noise is wide. Four or more without a mode, beside partials that have one, and of one decay.
std::vector<std::size_t> room_lines(const JudgedSpecimen& specimen) {
  constexpr std::size_t kFewest = 4;
  constexpr double kWidths = 3.0, kLeastHz = 3.0, kLouder = 2.0, kSameDecay = 2.5, kMost = 0.6;
  const std::vector<Partial>& partials = specimen.partials.partials;
  std::vector<std::size_t> beside;
  std::vector<double> decays;
  for (std::size_t i = 0; i < partials.size(); ++i) {
    const Partial& line = partials[i];
    if (item(specimen.mode_of_partial, i) >= 0 || !line.decay_per_s || !line.amplitude) continue;
    const double width_hz = std::max(kLeastHz, kWidths * *line.decay_per_s / kPi);
    for (std::size_t j = 0; j < partials.size(); ++j) {
      if (item(specimen.mode_of_partial, j) < 0 || !partials[j].amplitude) continue;
      if (std::abs(partials[j].frequency_hz - line.frequency_hz) > width_hz) continue;
      if (*line.amplitude > kLouder * *partials[j].amplitude) continue;
      beside.push_back(i);
      decays.push_back(*line.decay_per_s);
      break;
    }
  }
  if (beside.size() < kFewest) return {};
  const double decay = median_of(decays);
  std::vector<std::size_t> of_room;
  for (std::size_t k = 0; k < beside.size(); ++k)
    if (std::max(decays[k] / decay, decay / decays[k]) <= kSameDecay) of_room.push_back(beside[k]);
  const bool most = static_cast<double>(of_room.size()) >= kMost * static_cast<double>(beside.size());
  return of_room.size() >= kFewest && most ? of_room : std::vector<std::size_t>{};
}

struct Shares {
  double energy = 1.0;
  std::size_t n_strong = 0, n_strong_matched = 0;
  std::vector<std::size_t> missed;   ///< strong ones without a mode, strongest first
  std::vector<std::size_t> of_room;  ///< left out of all that
};

Shares shares_of(const JudgedSpecimen& specimen) {
  std::vector<double> energy = energies(specimen.partials);
  Shares shares;
  if (energy.empty()) return shares;
  shares.of_room = room_lines(specimen);
  for (const std::size_t i : shares.of_room) energy[i] = 0.0;
  const double strongest = *std::max_element(energy.begin(), energy.end());
  double matched = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < energy.size(); ++i) {
    const bool has_mode = item(specimen.mode_of_partial, i) >= 0;
    sum += energy[i];
    matched += has_mode ? energy[i] : 0.0;
    if (!(10.0 * std::log10(energy[i] / strongest) >= -kStrongDb)) continue;
    ++shares.n_strong;
    shares.n_strong_matched += has_mode;
    if (!has_mode) shares.missed.push_back(i);
  }
  shares.energy = matched / sum;
  std::stable_sort(shares.missed.begin(), shares.missed.end(),
                   [&](std::size_t a, std::size_t b) { return energy[a] > energy[b]; });
  return shares;
}

void judge_shares(const JudgedSpecimen& specimen, const Shares& shares, std::vector<Reason>& reasons) {
  if (shares.n_strong == 0) return;
  const double strong = static_cast<double>(shares.n_strong_matched) / static_cast<double>(shares.n_strong);
  const bool doubtful = shares.energy < 0.7 || strong < 0.75;
  const bool contradicted = (shares.energy < 0.3 || strong < 0.4) && shares.n_strong >= 4;
  if (shares.missed.empty()) return;
  Reason reason{ReasonKind::kUnmatched,
                contradicted ? Verdict::kContradicted
                : doubtful   ? Verdict::kDoubtful
                             : Verdict::kTrusted,
                specimen.name,
                "",
                "",
                strong,
                0.75,
                1.0};
  reason.text = std::to_string(shares.n_strong_matched) + " of " + std::to_string(shares.n_strong) +
                " strong partials and " + shown("%.0f %%", 100.0 * shares.energy) +
                " of the ring's energy lie on modes; the strongest without one: " + named(specimen, shares.missed);
  reasons.push_back(std::move(reason));
}

void judge_room(const JudgedSpecimen& specimen, const Shares& shares, std::vector<Reason>& reasons) {
  if (shares.of_room.empty()) return;
  std::vector<double> decays;
  for (const std::size_t i : shares.of_room) decays.push_back(*specimen.partials.partials[i].decay_per_s);
  reasons.push_back({ReasonKind::kRoom,
                     Verdict::kDoubtful,
                     specimen.name,
                     "",
                     std::to_string(shares.of_room.size()) + " lines beside partials of the body (" +
                         named(specimen, shares.of_room) + ") decay alike, by about " +
                         shown("%.3g", median_of(decays)) +
                         " per s: a room's reverberation, which the intervals do not hold; a microphone closer to the "
                         "body hears less of it",
                     static_cast<double>(shares.of_room.size()),
                     {},
                     {}});
}

/// Strong rings by a mode that should sound and has no partial, yet left out.
void judge_left_out(const JudgedSpecimen& specimen, const Shares& shares, std::vector<Reason>& reasons) {
  for (const std::size_t i : shares.missed) {
    const double at_hz = specimen.partials.partials[i].frequency_hz;
    int nearest = -1;
    for (Eigen::Index k = 0; k < specimen.frequency_hz.size(); ++k) {
      const bool taken = std::count(specimen.mode_of_partial.begin(), specimen.mode_of_partial.end(), k) > 0;
      const bool visible = k >= specimen.visibility.size() || specimen.visibility[k] > 0.1;
      const double off = std::abs(cents(at_hz, specimen.frequency_hz[k]));
      if (taken || !visible || off > kLeftOutCents) continue;
      if (nearest < 0 || off < std::abs(cents(at_hz, specimen.frequency_hz[nearest]))) nearest = static_cast<int>(k);
    }
    if (nearest < 0) continue;
    const double off = cents(at_hz, specimen.frequency_hz[nearest]);
    reasons.push_back({ReasonKind::kLeftOut,
                       Verdict::kDoubtful,
                       specimen.name,
                       "mode " + std::to_string(nearest),
                       "the clear ring at " + shown("%.6g Hz", at_hz) + " lies " + shown("%.1f", std::abs(off)) +
                           " cents " + (off > 0.0 ? "above" : "below") + " mode " + std::to_string(nearest) +
                           ", which nothing else explains, and was left out",
                       off,
                       {},
                       {}});
  }
}

void judge_unheard(const JudgedSpecimen& specimen, std::vector<Reason>& reasons) {
  std::vector<int> heard;
  for (const int mode : specimen.mode_of_partial) {
    if (mode >= 0) heard.push_back(mode);
  }
  if (heard.empty() || specimen.visibility.size() == 0) return;
  const int last = *std::max_element(heard.begin(), heard.end());
  std::vector<int> silent;
  int n_expected = 0;
  for (int k = 0; k <= last && k < specimen.frequency_hz.size() && k < specimen.visibility.size(); ++k) {
    const auto near = [&](int other) {
      return std::abs(cents(specimen.frequency_hz[k], item(specimen.frequency_hz, other))) <= kPairCents;
    };
    const bool is_heard = std::any_of(heard.begin(), heard.end(), near);
    const bool twin = k > 0 && near(k - 1);
    if (twin || (!is_heard && specimen.visibility[k] < kVisible)) continue;
    ++n_expected;
    if (!is_heard) silent.push_back(k);
  }
  if (silent.empty()) return;
  const double share = 1.0 - static_cast<double>(silent.size()) / n_expected;
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, silent.size()); ++i)
    names +=
        (i ? ", " : "") + std::to_string(silent[i]) + " (" + shown("%.6g Hz", specimen.frequency_hz[silent[i]]) + ")";
  reasons.push_back(
      {ReasonKind::kUnheard, share < 0.4 && n_expected >= 5 ? Verdict::kDoubtful : Verdict::kTrusted, specimen.name, "",
       std::to_string(silent.size()) + " of " + std::to_string(n_expected) +
           " modes that a strike should make sound were not heard: mode " + names + (silent.size() > 3 ? ", ..." : ""),
       share, 0.4, 1.0});
}

void judge_takes(const JudgedSpecimen& specimen, std::vector<Reason>& reasons) {
  if (specimen.n_takes == 1)
    reasons.push_back(
        {ReasonKind::kTakes,
         Verdict::kTrusted,
         specimen.name,
         "",
         "one take only: what differs from take to take (often 2 to 24 times one take's own deviation) is not "
         "in the intervals",
         {},
         {},
         {}});
  if (specimen.n_takes == 0)
    reasons.push_back(
        {ReasonKind::kTakes,
         Verdict::kTrusted,
         specimen.name,
         "",
         "a table of partials: what differs from take to take is in the intervals as far as its deviations hold it",
         {},
         {},
         {}});
  if (specimen.take_scatter_cents && *specimen.take_scatter_cents > 4.0)
    reasons.push_back({ReasonKind::kTakes,
                       *specimen.take_scatter_cents > 40.0 ? Verdict::kContradicted : Verdict::kDoubtful, specimen.name,
                       "",
                       "the takes disagree by " + shown("%.1f", *specimen.take_scatter_cents) +
                           " cents: another body, support or temperature?",
                       *specimen.take_scatter_cents, 0.0, 4.0});
  if (specimen.take_share && *specimen.take_share < 0.5)
    reasons.push_back({ReasonKind::kTakes, Verdict::kDoubtful, specimen.name, "",
                       "a take has only " + shown("%.0f %%", 100.0 * *specimen.take_share) +
                           " of its strong partials in common with the others: the same body?",
                       *specimen.take_share, 0.5, 1.0});
}

}  // namespace

void judge_partials(const JudgeInput& input, std::vector<Reason>& reasons) {
  for (const JudgedSpecimen& specimen : input.specimens) {
    const Shares shares = shares_of(specimen);
    judge_shares(specimen, shares, reasons);
    judge_room(specimen, shares, reasons);
    judge_left_out(specimen, shares, reasons);
    judge_unheard(specimen, reasons);
    judge_takes(specimen, reasons);
  }
}

}  // namespace klang::fit::detail
