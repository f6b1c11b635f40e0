#include "core/sound/liquid_scene/detail/cell_ear.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"

namespace klang::liquid_scene {
namespace {

using Complex = std::complex<double>;

constexpr double kLowestBin_hz = 20.0;
constexpr double kFirstLife_s = 0.08, kLongestLife_s = 0.64, kSmallChange = 0.1, kLargeChange = 0.2;
// Per wavelength, by the mean edge: Pouring is then right to 2 to 4 % against twice as fine an air, with 5 to 8 to 20 %.
constexpr double kEnoughElements = 10.0;
constexpr double kOtherElements = 1.5;  // times as many or few tell an error
// With this tolerance a resonance of Q 50 is right to a percent, with 3e-3 by nothing (LiquidCells.*); Splash takes 900 iterations at
// 12 kHz, hundreds of modes below.
constexpr LiquidCells::Limits kLimits{1e-4, 4000};

}  // namespace

CellEar::CellEar(const liquid::LiquidFrames& frames, const bubble::ReciprocalOptions& options, int bins_per_octave,
                 Monitor& monitor)
    : frames_(frames), options_(options), bins_per_octave_(bins_per_octave), monitor_(monitor), life_s_(kFirstLife_s) {}

double CellEar::bin_hz(int bin) const { return kLowestBin_hz * std::exp2(static_cast<double>(bin) / bins_per_octave_); }

bool CellEar::due(double time_s) const { return !elements_[0] || time_s - made_s_ >= life_s_ * (1.0 - 1e-9); }

std::size_t CellEar::level(double frequency_hz) const {
  std::size_t level = 0;
  while (level + 1 < kLevels &&
         elements_[level]->elements_per_wavelength(frequency_hz, options_.pass.air) < kEnoughElements)
    ++level;
  return level;
}

Eigen::MatrixXcd CellEar::field(const bubble::EarElements& elements, double frequency_hz) const {
  return elements.field(frequency_hz, {ear_m_}, options_.pass.air, monitor_);
}

bool CellEar::renew(const bubble::LiquidBoundary& boundary, const CellBody& body, const Eigen::Vector3d& ear_m,
                    double time_s) {
  std::optional<CellBox> box = cell_box(body.surface, frames_.cell_m());
  if (!box) return false;
  box->with_solids = body.with_solids;
  if (!box_ || !box_->same_cells(*box)) waves_.clear();
  box_ = box;
  old_q_.clear();
  for (auto& [bin, q] : q_)
    if (level(bin_hz(bin)) == 0) old_q_[bin] = std::move(q);
  q_.clear();
  old_elements_ = std::move(elements_[0]);
  make_elements(boundary);
  ear_m_ = ear_m;
  made_s_ = time_s;
  return true;
}

void CellEar::make_elements(const bubble::LiquidBoundary& boundary) {
  for (std::size_t level = 0; level < kLevels; ++level)
    elements_[level] = std::make_unique<const bubble::EarElements>(boundary, options_.air_vertices << level);
}

CellEarState CellEar::state() const {
  KLANG_CHECK(!old_elements_, "the air of this frame has been solved");
  CellEarState state{made_s_, life_s_, change_, changed_hz_, q_, 0, {}, {}};
  if (!waves_.empty()) state.n_cells = waves_.begin()->second.waves.w.size();
  for (std::uint32_t c = 0; c < state.n_cells; ++c)
    if (std::any_of(waves_.begin(), waves_.end(),
                    [&](const auto& wave) { return wave.second.waves.w[c] != std::complex<float>(); }))
      state.wet.push_back(c);
  for (const auto& [bubble, wave] : waves_) {
    if (!wave.waves.converged) continue;  // no start for another
    CellEarState::Wave& kept = state.waves[bubble];
    kept.frequency_hz = wave.frequency_hz;
    for (const std::uint32_t c : state.wet) kept.w.push_back(wave.waves.w[c]);
  }
  return state;
}

bool CellEar::restore(CellEarState state, const bubble::LiquidBoundary& boundary, const CellBody& body,
                      const Eigen::Vector3d& ear_m) {
  box_ = cell_box(body.surface, frames_.cell_m());
  if (!box_) return false;
  box_->with_solids = body.with_solids;
  make_elements(boundary);
  ear_m_ = ear_m;
  made_s_ = state.made_s;
  life_s_ = state.life_s;
  change_ = state.change;
  changed_hz_ = state.changed_hz;
  q_ = std::move(state.q);
  waves_.clear();
  const std::size_t n_cells = static_cast<std::size_t>(box_->n[0]) * static_cast<std::size_t>(box_->n[1]) *
                              static_cast<std::size_t>(box_->n[2]);
  const auto fits = [&](const auto& wave) { return wave.second.w.size() == state.wet.size(); };
  if (state.waves.empty()) return true;
  KLANG_CHECK(state.n_cells == n_cells && std::all_of(state.waves.begin(), state.waves.end(), fits) &&
                  std::all_of(state.wet.begin(), state.wet.end(), [&](std::uint32_t c) { return c < n_cells; }),
              "waves of these cells");
  for (const auto& [bubble, wave] : state.waves) {
    Wave& here = waves_[bubble];
    here.frequency_hz = wave.frequency_hz;
    here.waves.converged = true;
    here.waves.w.assign(n_cells, {});
    for (std::size_t i = 0; i < state.wet.size(); ++i) here.waves.w[state.wet[i]] = wave.w[i];
  }
  return true;
}

void CellEar::enter(std::size_t frame) {
  cells_.emplace(frames_, frame, *box_);
  for (auto& carrier : carriers_) carrier.reset();
  heard_.clear();
}

const bubble::EarElements::Carrier& CellEar::carrier(std::size_t level) {
  if (!carriers_[level]) carriers_[level] = elements_[level]->carrier(cells_->surface_m());
  return *carriers_[level];
}

const Eigen::VectorXcd& CellEar::heard_in_bin(int bin) {
  Eigen::VectorXcd& here = heard_[bin];
  if (here.size() != 0) return here;
  const std::size_t of = level(bin_hz(bin));
  Eigen::MatrixXcd& q = q_[bin];
  if (q.size() == 0) q = field(*elements_[of], bin_hz(bin));
  return here = carrier(of)(q).col(0);
}

Eigen::VectorXcd CellEar::heard(double frequency_hz) {
  const double place = bins_per_octave_ * std::log2(frequency_hz / kLowestBin_hz);
  const int below = static_cast<int>(std::floor(place));
  const double share = place - below;
  const Eigen::VectorXcd &low = heard_in_bin(below), &high = heard_in_bin(below + 1);
  const auto k = [&](double hz) { return options_.pass.air.wavenumber_per_m(hz); };
  Eigen::VectorXcd q(low.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double way = (cells_->surface_m().col(i) - ear_m_).norm();
    q[i] = (1.0 - share) * low[i] * std::polar(1.0, (k(bin_hz(below)) - k(frequency_hz)) * way) +
           share * high[i] * std::polar(1.0, (k(bin_hz(below + 1)) - k(frequency_hz)) * way);
  }
  return q;
}

/// The bin by which the old air and the new one are compared: the highest that both have solved with elements enough for its wavelength,
/// else the highest of that kind that there is, and it is solved.
int CellEar::compared_bin() const {
  int best = -1;
  for (const auto& [bin, q] : old_q_)
    if (level(bin_hz(bin)) == 0 && q_.contains(bin)) best = std::max(best, bin);
  if (best >= 0) return best;
  for (int bin = 0; level(bin_hz(bin)) == 0; ++bin) best = bin;
  return std::max(best, 0);
}

void CellEar::note_change() {
  const int bin = compared_bin();
  Eigen::MatrixXcd &q = q_[bin], &old_q = old_q_[bin];
  if (q.size() == 0) q = field(*elements_[0], bin_hz(bin));
  if (old_q.size() == 0) old_q = field(*old_elements_, bin_hz(bin));
  const Eigen::MatrixXcd before = old_elements_->carrier(cells_->surface_m())(old_q), now = carrier(0)(q);
  change_ = (now - before).norm() / now.norm();
  changed_hz_ = bin_hz(bin);
  old_elements_.reset();
  old_q_.clear();
  if (change_ < kSmallChange) life_s_ = std::min(2.0 * life_s_, kLongestLife_s);
  if (change_ > kLargeChange) life_s_ = std::max(0.5 * life_s_, kFirstLife_s);
}

LiquidCells::Question CellEar::question(double frequency_hz, Eigen::VectorXcd q,
                                        const std::vector<std::complex<float>>* start) const {
  const Complex give(0.0, options_.pass.liquid.wavenumber_per_m(frequency_hz) * options_.pass.wall_admittance);
  return {options_.pass.liquid_wavenumber_per_m(frequency_hz), give, std::move(q), start};
}

/// Its own waves of the frame before, or those of the nearest pitch.
const std::vector<std::complex<float>>* CellEar::start(std::size_t bubble, double frequency_hz) const {
  const auto own = waves_.find(bubble);
  if (own != waves_.end() && own->second.waves.converged) return &own->second.waves.w;
  const Wave* nearest = nullptr;
  for (const auto& [number, wave] : waves_)
    if (wave.waves.converged && (nearest == nullptr || std::abs(wave.frequency_hz - frequency_hz) <
                                                           std::abs(nearest->frequency_hz - frequency_hz)))
      nearest = &wave;
  return nearest == nullptr ? nullptr : &nearest->waves.w;
}

void CellEar::solve(const std::map<std::size_t, double>& pitch_of_bubble) {
  // Neighbours in frequency are solved side by side.
  std::vector<std::pair<double, std::size_t>> order;
  for (const auto& [bubble, pitch] : pitch_of_bubble) order.emplace_back(pitch, bubble);
  std::sort(order.begin(), order.end());
  std::vector<LiquidCells::Question> questions;
  for (const auto& [pitch, bubble] : order) {
    monitor_.throw_if_stopped();
    questions.push_back(question(pitch, heard(pitch), start(bubble, pitch)));
  }
  std::vector<LiquidCells::Waves> found = cells_->solve(questions, kLimits, monitor_);
  std::map<std::size_t, Wave> next;
  for (std::size_t i = 0; i < order.size(); ++i) {
    next[order[i].second] = {order[i].first, std::move(questions[i].q), std::move(found[i])};
  }
  waves_ = std::move(next);
  if (old_elements_) note_change();
}

Complex CellEar::strength(const Wave& wave, const bubble::SwingingBubble& at) const {
  return options_.pass.air.density_kg_m3 / options_.pass.liquid.density_kg_m3 *
         bubble::bubble_source_strength(at.radius_m, wave.frequency_hz, options_.pass.liquid.density_kg_m3);
}

Complex CellEar::pressure(std::size_t bubble, const bubble::SwingingBubble& at) const {
  const Wave& of = waves_.at(bubble);
  return strength(of, at) * cells_->at(at.position_m, of.waves, of.heard);
}

std::pair<Eigen::VectorXcd, double> CellEar::other_air(double frequency_hz, const bubble::LiquidBoundary& boundary,
                                                       const Eigen::Matrix3Xd& points_m) const {
  const std::size_t of = level(frequency_hz);
  const double n = elements_[of]->n_elements();
  const auto found = [&](const bubble::EarElements& other) {
    return std::pair(Eigen::VectorXcd(other.carrier(points_m)(field(other, frequency_hz)).col(0)),
                     1.0 / std::abs(1.0 - n / other.n_elements()));
  };
  for (std::size_t finer = of + 1; finer < kLevels; ++finer)
    if (elements_[finer]->n_elements() >= kOtherElements * n) return found(*elements_[finer]);
  for (std::size_t coarser = of; coarser-- > 0;)
    if (n >= kOtherElements * elements_[coarser]->n_elements()) return found(*elements_[coarser]);
  return found(bubble::EarElements(boundary, std::max(static_cast<int>(n) / 8, 22)));
}

std::optional<CellEar::Error> CellEar::error(std::size_t bubble, const bubble::SwingingBubble& at,
                                             const bubble::LiquidBoundary& boundary, std::size_t frame) {
  const Wave& of = waves_.at(bubble);
  if (!of.waves.converged) return Error{0.0, 0.0, 1.0, 0.0};
  const auto coarse_box = coarser_box(*box_);
  if (!coarse_box) return std::nullopt;
  const Complex here = cells_->at(at.position_m, of.waves, of.heard);
  const std::size_t level_here = level(of.frequency_hz);
  bool known = true;
  const auto value_with = [&](const LiquidCells& cells, const Eigen::VectorXcd& q) {
    const auto waves = cells.solve({question(of.frequency_hz, q, &of.waves.w)}, kLimits, monitor_);
    known = known && waves[0].converged;
    return cells.at(at.position_m, waves[0], q);
  };
  const Eigen::MatrixXcd own = field(*elements_[level_here], of.frequency_hz);
  const Complex at_pitch = value_with(*cells_, carrier(level_here)(own).col(0));
  const auto [heard, share] = other_air(of.frequency_hz, boundary, cells_->surface_m());
  const double air = share * std::abs(value_with(*cells_, heard) - at_pitch);
  const LiquidCells coarse(frames_, frame, *coarse_box);
  const double ratio = coarse_box->cell_m / box_->cell_m;
  const double cells =
      std::abs(value_with(coarse, elements_[level_here]->carrier(coarse.surface_m())(own).col(0)) - at_pitch) /
      (ratio * ratio - 1.0);
  if (!known) return Error{0.0, 0.0, 1.0, 0.0};
  const double size = std::abs(here);
  // What moves shifts phases, by so much more as the pitch is higher.
  const double age = change_ > 0.0 ? 0.5 * change_ * of.frequency_hz / changed_hz_ : 0.0;
  return Error{std::abs(at_pitch - here) / size, air / size, cells / size, age};
}

bubble::EarField CellEar::air_field(std::size_t bubble, const bubble::LiquidBoundary& boundary) const {
  const double frequency_hz = waves_.at(bubble).frequency_hz;
  const bubble::EarElements& elements = *elements_[level(frequency_hz)];
  bubble::EarField air;
  air.frequency_hz = frequency_hz;
  air.q = elements.carrier(boundary)(field(elements, frequency_hz));
  const Eigen::Matrix3Xd points = boundary.surface().vertices_m.transpose();
  const auto [other, share] = other_air(frequency_hz, boundary, points);
  air.q_coarse = air.q.col(0) + 3.0 * share * (other - air.q.col(0));  // a third of it counts
  return air;
}

}  // namespace klang::liquid_scene
