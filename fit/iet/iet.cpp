#include "fit/iet/iet.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/shared_jobs.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/iet/iet_formulas.hpp"
#include "fit/iet/iet_meter.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "fit/tune/tune.hpp"

namespace klang::fit {
namespace {

constexpr double kAssumedNu = 0.3, kLowestNu = 0.0, kHighestNu = 0.495;
constexpr double kStartModulusPa = 1e11;
/// A foam of ceramics, and osmium with some to spare: no solid is beyond.
constexpr double kLightest_kg_m3 = 10.0, kHeaviest_kg_m3 = 25000.0;
constexpr const char* kNoRing = "no partial that decays";

mesh::ShapeSpec shape_of(const IetSpecimen& given) {
  switch (given.shape) {
    case IetShape::kBar:
      return {
          "box", {{"length_m", *given.length_m}, {"width_m", *given.width_m}, {"height_m", *given.thickness_m}}, {}};
    case IetShape::kRod:
      return {"rod", {{"length_m", *given.length_m}, {"radius_m", 0.5 * *given.diameter_m}}, {}};
    case IetShape::kDisc:
      break;
  }
  return {"rod", {{"length_m", *given.thickness_m}, {"radius_m", 0.5 * *given.diameter_m}}, {}};
}

/// Share of a mode's motion in which sections turn about the axis as wholes, and how often the angle changes its sign.
struct Twist {
  double share = 0.0;
  int n_nodes = 0;
};

Twist twist(const mesh::TetMesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& shape, int axis) {
  constexpr int kSlices = 40;
  const int p = (axis + 1) % 3, q = (axis + 2) % 3;
  const auto along = mesh.nodes_m.col(axis);
  const double low = along.minCoeff(), span = along.maxCoeff() - low;
  const double centre_p = 0.5 * (mesh.nodes_m.col(p).minCoeff() + mesh.nodes_m.col(p).maxCoeff());
  const double centre_q = 0.5 * (mesh.nodes_m.col(q).minCoeff() + mesh.nodes_m.col(q).maxCoeff());
  Eigen::VectorXd moment = Eigen::VectorXd::Zero(kSlices), inertia = moment;
  double total = 0.0;
  for (Eigen::Index node = 0; node < mesh.nodes_m.rows(); ++node) {
    const auto slice =
        std::min<Eigen::Index>(kSlices - 1, static_cast<Eigen::Index>((along[node] - low) / span * kSlices));
    const Eigen::Vector3d u = shape.segment<3>(3 * node);
    const double y = mesh.nodes_m(node, p) - centre_p, z = mesh.nodes_m(node, q) - centre_q;
    moment[slice] += y * u[q] - z * u[p];
    inertia[slice] += y * y + z * z;
    total += u.squaredNorm();
  }
  Twist result;
  double turning = 0.0;
  Eigen::VectorXd angle = Eigen::VectorXd::Zero(kSlices);
  for (int slice = 0; slice < kSlices; ++slice) {
    if (!(inertia[slice] > 0.0)) continue;
    angle[slice] = moment[slice] / inertia[slice];
    turning += moment[slice] * angle[slice];
  }
  int sign = 0;
  for (int slice = 0; slice < kSlices; ++slice) {
    if (std::abs(angle[slice]) < 0.02 * angle.cwiseAbs().maxCoeff()) continue;
    const int now = angle[slice] > 0.0 ? 1 : -1;
    result.n_nodes += sign != 0 && now != sign ? 1 : 0;
    sign = now;
  }
  result.share = total > 0.0 ? turning / total : 0.0;
  return result;
}

}  // namespace

namespace detail {

/// The body's spectrum as a function of E and nu, and which of its modes the standard asks for.
class IetModel {
 public:
  explicit IetModel(const IetSpecimen& given) {
    specimen_.name = given.specimen;
    specimen_.shape = shape_of(given);
    mesh::validate(*specimen_.shape);
    specimen_.mass_kg = given.mass_kg;
    volume_m3_ = mesh::shape_volume_m3(*specimen_.shape);
    const solid::Material start = solid::from_youngs_modulus(kStartModulusPa, kAssumedNu, given.mass_kg / volume_m3_);
    const double speed = std::sqrt(kStartModulusPa / start.density_kg_m3);
    // The tenth mode or so of a slender bar lies below the first extensional ones.
    const double across = given.shape == IetShape::kDisc ? *given.diameter_m : *given.length_m;
    const double thick = given.shape == IetShape::kRod ? *given.diameter_m : *given.thickness_m;
    const double first_hz = thick * speed / (across * across);
    const SpecimenBody body = make_body(specimen_, start, 12.0 * first_hz);
    ReducedSpectrumOptions options;
    options.count = 14;
    options.band = {0.0, 12.0 * first_hz};
    model_.emplace(specimen_, body, std::vector<std::string>{}, options, silent_monitor());
    find_modes(given.shape);
  }

  Eigen::VectorXd frequencies_hz(double youngs_modulus_pa, double nu) const {
    const solid::Material material =
        solid::from_youngs_modulus(youngs_modulus_pa, nu, specimen_.mass_kg.value() / volume_m3_);
    const Spectrum spectrum =
        model_->spectrum({material.lame_lambda_pa, material.lame_mu_pa, material.density_kg_m3, {}});
    return (0.5 * spectrum.log_angular_frequency_sq.array()).exp() / (2.0 * kPi);
  }
  int first() const { return first_; }    ///< flexural, or first natural
  int second() const { return second_; }  ///< torsional, or second natural

  /// Second over first frequency.
  double ratio(double nu) const {
    const Eigen::VectorXd f = frequencies_hz(kStartModulusPa, nu);
    return f[second_] / f[first_];
  }
  double youngs_modulus_pa(double first_hz, double nu) const {
    return kStartModulusPa * std::pow(first_hz / frequencies_hz(kStartModulusPa, nu)[first_], 2);
  }
  /// Poisson's ratio at which the ratio is this; empty: at none. Secant bisection: the ratio is monotone.
  std::optional<double> poissons_ratio(double ratio_wanted) const {
    double low = kLowestNu, high = kHighestNu;
    double at_low = ratio(low) - ratio_wanted, at_high = ratio(high) - ratio_wanted;
    if (!(at_low * at_high <= 0.0)) return std::nullopt;
    for (int i = 0; i < 60 && high - low > 1e-10; ++i) {
      const double middle = i % 3 == 2 ? 0.5 * (low + high) : low - at_low * (high - low) / (at_high - at_low);
      const double there = ratio(middle) - ratio_wanted;
      if (std::abs(there) < 1e-13) return middle;
      if (there * at_low <= 0.0) {
        high = middle;
        at_high = there;
      } else {
        low = middle;
        at_low = there;
      }
    }
    return 0.5 * (low + high);
  }

 private:
  void find_modes(IetShape shape) {
    const modal::ModalModel& nominal = model_->nominal().model;
    const Eigen::VectorXd f = nominal.frequency_hz();
    if (shape == IetShape::kDisc) {
      // (2,0) is a pair and the lowest; (0,1) is the lowest that stands alone.
      first_ = 0;
      for (int k = 1; k + 1 < f.size() && second_ < 0; ++k) {
        const bool alone = f[k] / f[k - 1] > 1.0 + 1e-4 && f[k + 1] / f[k] > 1.0 + 1e-4;
        if (alone) second_ = k;
      }
    } else {
      const auto families = bending_modes(*specimen_.shape, nominal);
      if (!families.empty() && !families.front().empty()) first_ = families.front().front();
      Eigen::Index axis = 0;
      (nominal.mesh.nodes_m.colwise().maxCoeff() - nominal.mesh.nodes_m.colwise().minCoeff()).maxCoeff(&axis);
      for (int k = 0; k < f.size() && second_ < 0; ++k) {
        const Twist t = twist(nominal.mesh, nominal.shapes.col(k), static_cast<int>(axis));
        if (t.share > 0.5 && t.n_nodes == 1) second_ = k;
      }
    }
    if (first_ < 0 || second_ < 0)
      throw InputError("specimen " + specimen_.name, "has no first flexural and torsional mode among the lowest 14", "",
                       "a slender bar or rod, a flat disc");
  }

  Specimen specimen_;
  double volume_m3_ = 0.0;
  std::optional<ReducedSpectrum> model_;
  int first_ = -1, second_ = -1;
};

}  // namespace detail

namespace {

using detail::IetModel;

/// A way to read the partials.
struct Reading {
  const Partial* first = nullptr;
  const Partial* second = nullptr;
  double youngs_modulus_pa = 0.0, nu = kAssumedNu;
  double explained = -1.0;             ///< share of the partials' strength on a mode
  const Partial* not_taken = nullptr;  ///< for the second one: may be another mode
};

/// Of each mode from a frequency, without sign.
Eigen::ArrayXd cents_off(const Eigen::VectorXd& f, double frequency_hz) {
  return (1200.0 * (f.array() / frequency_hz).log() / std::log(2.0)).abs();
}

/// Share of the strength (square root of amplitude) of the partials up to the model's highest mode that lies on modes.
double explained_share(const Eigen::VectorXd& f, const std::vector<Partial>& partials) {
  constexpr double kWidthCents = 25.0;
  double all = 0.0, explained = 0.0;
  for (const Partial& partial : partials) {
    if (partial.frequency_hz > 1.02 * f.maxCoeff()) continue;
    const double strength = std::sqrt(partial.amplitude.value_or(1.0));
    const double off = cents_off(f, partial.frequency_hz).minCoeff();
    all += strength;
    explained += strength * std::exp(-0.5 * std::pow(off / kWidthCents, 2));
  }
  return all > 0.0 ? explained / all : 0.0;
}

/// How far partials lie from modes: the sum of ln(1 + (off / 1 cent)^2), minus twice the logarithm of a likelihood with long tails.
/// @param second  this one last: it may not lie on the mode that is not_on (-1: none), nor on one that another partial has
double misfit(const Eigen::VectorXd& f, const std::vector<Partial>& partials, const Partial* second, int not_on) {
  constexpr double kCents = 1.0, kNoMode = 25.0;
  double sum = 0.0;
  std::vector<Eigen::Index> taken;
  if (not_on >= 0) taken.push_back(not_on);
  const auto add = [&](Eigen::ArrayXd off) {
    Eigen::Index nearest = 0;
    const double least = off.minCoeff(&nearest);
    sum += std::log1p(std::pow(std::min(least, kNoMode) / kCents, 2));
    return nearest;
  };
  for (const Partial& partial : partials)
    if (&partial != second && partial.frequency_hz <= 1.02 * f.maxCoeff())
      taken.push_back(add(cents_off(f, partial.frequency_hz)));
  Eigen::ArrayXd off = cents_off(f, second->frequency_hz);
  if (not_on >= 0) off(taken) = kNoMode;
  add(off);
  return sum;
}

/// Whether the second partial of a reading can be another mode of a body with the same first one, at some Poisson's ratio, that
/// explains what rings about as well.
bool second_may_be_another(const IetModel& model, const std::vector<Partial>& partials, const Reading& reading) {
  constexpr double kNuStep = 0.0025, kAboutAsWell = 4.0;  // e^2 times less likely
  const Eigen::VectorXd read = model.frequencies_hz(reading.youngs_modulus_pa, reading.nu);
  const double taken = misfit(read, partials, reading.second, -1);
  for (double nu = kLowestNu; nu <= kHighestNu; nu += kNuStep) {
    const Eigen::VectorXd f = model.frequencies_hz(model.youngs_modulus_pa(reading.first->frequency_hz, nu), nu);
    if (misfit(f, partials, reading.second, model.second()) <= taken + kAboutAsWell) return true;
  }
  return false;
}

Reading best_reading(const IetModel& model, const std::vector<Partial>& partials) {
  constexpr std::size_t kMostFirst = 6;
  constexpr double kFaintest = 1.0 / 300.0, kBonus = 0.05;
  double loudest = 0.0;
  for (const Partial& partial : partials) loudest = std::max(loudest, partial.amplitude.value_or(0.0));
  Reading best;
  double best_score = -1.0;
  const auto consider = [&](Reading reading) {
    reading.explained = explained_share(model.frequencies_hz(reading.youngs_modulus_pa, reading.nu), partials);
    const double score = reading.explained + (reading.second != nullptr ? kBonus : 0.0);
    if (score <= best_score) return;
    best_score = score;
    best = reading;
  };
  const double low = std::min(model.ratio(kLowestNu), model.ratio(kHighestNu));
  const double high = std::max(model.ratio(kLowestNu), model.ratio(kHighestNu));
  for (std::size_t i = 0; i < std::min(kMostFirst, partials.size()); ++i) {
    const Partial& first = partials[i];
    if (first.amplitude.value_or(loudest) < kFaintest * loudest) continue;
    consider({&first, nullptr, model.youngs_modulus_pa(first.frequency_hz, kAssumedNu), kAssumedNu, 0.0});
    for (const Partial& second : partials) {
      const double ratio = second.frequency_hz / first.frequency_hz;
      if (&second == &first || ratio < low || ratio > high) continue;
      const auto nu = model.poissons_ratio(ratio);
      if (nu) consider({&first, &second, model.youngs_modulus_pa(first.frequency_hz, *nu), *nu, 0.0});
    }
  }
  if (best.second != nullptr && second_may_be_another(model, partials, best)) {
    best.not_taken = best.second;
    best.second = nullptr;
    best.nu = kAssumedNu;
    best.youngs_modulus_pa = model.youngs_modulus_pa(best.first->frequency_hz, kAssumedNu);
    best.explained = explained_share(model.frequencies_hz(best.youngs_modulus_pa, best.nu), partials);
  }
  return best;
}

void apply_bar_or_rod(const Reading& reading, IetRow& row) {
  const IetSpecimen& g = row.given;
  const bool bar = g.shape == IetShape::kBar;
  const e1876::Bar as_bar{*g.length_m, g.width_m.value_or(0.0), g.thickness_m.value_or(0.0), g.mass_kg};
  const e1876::Rod as_rod{*g.length_m, g.diameter_m.value_or(0.0), g.mass_kg};
  const auto young = [&](double nu) {
    return bar ? e1876::bar_youngs_modulus_pa(as_bar, *row.flexural_hz, nu)
               : e1876::rod_youngs_modulus_pa(as_rod, *row.flexural_hz, nu);
  };
  double nu = kAssumedNu;
  if (reading.second != nullptr) {
    row.torsional_hz = reading.second->frequency_hz;
    row.g_e1876_pa = bar ? e1876::bar_shear_modulus_pa(as_bar, *row.torsional_hz)
                         : e1876::rod_shear_modulus_pa(as_rod, *row.torsional_hz);
    for (int round = 0; round < 50; ++round) nu = std::clamp(0.5 * young(nu) / *row.g_e1876_pa - 1.0, -0.9, 0.9);
    row.nu_e1876 = nu;
  }
  row.e_e1876_pa = young(nu);
}

/// The standard's tables of K1, K2 and nu by t/r come from the theory of thick plates; here they are computed by the model.
void apply_disc(const IetModel& model, const Reading& reading, IetRow& row) {
  const e1876::Disc disc{*row.given.diameter_m, *row.given.thickness_m, row.given.mass_kg};
  const Eigen::VectorXd f = model.frequencies_hz(kStartModulusPa, reading.nu);
  const auto by = [&](double frequency_hz, int mode) {
    const double factor = e1876::disc_factor(disc, f[mode], kStartModulusPa, reading.nu);
    return e1876::disc_youngs_modulus_pa(disc, frequency_hz, factor, reading.nu);
  };
  row.e_e1876_pa = by(*row.flexural_hz, model.first());
  if (reading.second == nullptr) return;
  row.second_hz = reading.second->frequency_hz;
  row.e_e1876_pa = 0.5 * (*row.e_e1876_pa + by(*row.second_hz, model.second()));
  row.nu_e1876 = reading.nu;
  row.g_e1876_pa = *row.e_e1876_pa / (2.0 * (1.0 + reading.nu));
}

std::vector<Partial> rings_of(const std::vector<Partial>& all) {
  std::vector<Partial> rings;
  for (const Partial& partial : all)
    if (partial.is_ring()) rings.push_back(partial);
  return rings;
}

void add_remark(IetRow& row, const std::string& remark) { row.remark += (row.remark.empty() ? "" : "; ") + remark; }

IetRow bare_row(const IetSpecimen& given) {
  IetRow row;
  row.given = given;
  const double density_kg_m3 = given.mass_kg / mesh::shape_volume_m3(shape_of(given));
  row.density_kg_m3 = density_kg_m3;
  if (!(density_kg_m3 >= kLightest_kg_m3 && density_kg_m3 <= kHeaviest_kg_m3)) {
    char text[120];
    std::snprintf(text, sizeof text, "a density of %.3g kg/m3: are dimensions in metres, mass in kilograms?",
                  density_kg_m3);
    row.remark = text;
  }
  return row;
}

/// What no solid has, or what the two ways contradict each other in.
void judge(IetRow& row) {
  constexpr double kFarApartPercent = 5.0;
  constexpr double kStiffest_pa = 1.2e12,
                   kFastest_m_s = 18.5e3;  // diamond has 1.05e12 to 1.2e12 Pa and 17.3 to 18.4 km/s
  const auto doubt = [&row](const std::string& remark) {
    row.implausible = true;
    add_remark(row, remark);
  };
  const auto is_ratio = [](double nu) { return nu >= 0.0 && nu <= 0.5; };
  char text[160];
  if (std::abs(*row.difference_percent) > kFarApartPercent) {
    std::snprintf(text, sizeof text, "closed form and full model are %+.3g %% apart%s", *row.difference_percent,
                  row.given.shape == IetShape::kBar ? ": are width and thickness changed over?" : "");
    doubt(text);
  } else if (row.nu_e1876 && !is_ratio(*row.nu_e1876)) {
    std::snprintf(text, sizeof text, "Poisson's ratio %.3g of the closed forms is that of no solid", *row.nu_e1876);
    doubt(text);
  }
  if (!(*row.e_model_pa <= kStiffest_pa && std::sqrt(*row.e_model_pa / *row.density_kg_m3) <= kFastest_m_s))
    doubt("stiffer than any solid: is that the first flexural frequency?");
}

/// @param partials  that decay; not empty
IetRow measured_row(const IetSpecimen& given, const IetModel& model, const std::vector<Partial>& partials) {
  IetRow row = bare_row(given);
  const Reading reading = best_reading(model, partials);
  row.flexural_hz = reading.first->frequency_hz;
  row.explained_share = reading.explained;
  row.nu_assumed = reading.second == nullptr;
  if (reading.first->decay_per_s) row.q_inverse_flexural = *reading.first->decay_per_s / (kPi * *row.flexural_hz);
  if (given.shape == IetShape::kDisc) {
    apply_disc(model, reading, row);
  } else {
    apply_bar_or_rod(reading, row);
  }
  row.e_model_pa = reading.youngs_modulus_pa;
  if (reading.second != nullptr) {
    row.nu_model = reading.nu;
    row.g_model_pa = reading.youngs_modulus_pa / (2.0 * (1.0 + reading.nu));
  } else {
    std::string why = given.shape == IetShape::kDisc ? "no second natural frequency" : "no torsional frequency";
    if (reading.not_taken != nullptr)
      why += " that is not another mode as well (" +
             to_text(std::round(10.0 * reading.not_taken->frequency_hz) / 10.0) + " Hz)";
    add_remark(row, why + ": Poisson's ratio is assumed (0.3)");
  }
  if (reading.explained < 0.5) add_remark(row, "most of what rings is no mode of this body");
  row.difference_percent = 100.0 * (*row.e_e1876_pa / *row.e_model_pa - 1.0);
  judge(row);
  return row;
}

IetRow measured_row(const IetSpecimen& given, const std::filesystem::path& folder) {
  IetRow row = bare_row(given);
  const audio::Signal recording = audio::read_sound(folder / given.recording);
  if (!(recording.samples.cwiseAbs().maxCoeff() > 0.0)) {
    add_remark(row, "the recording is silent");
    return row;
  }
  RingdownOptions ringdown;
  ringdown.band = {20.0, 0.48 * recording.sample_rate_hz};
  const RingdownResult rings = identify_ringdown(recording, ringdown, silent_monitor());
  if (!rings.usable()) {
    add_remark(row, rings.message);
    return row;
  }
  const std::vector<Partial> partials = rings_of(rings.partials.partials);
  if (partials.empty()) {
    add_remark(row, kNoRing);
    return row;
  }
  return measured_row(given, IetModel(given), partials);
}

std::string packed(const IetRow& row) {
  std::string bytes;
  nlohmann::json::to_cbor(json_of(row), bytes);
  return bytes;
}

IetRow unpacked(std::string_view bytes) {
  return read_fields<IetRow>(nlohmann::json::from_cbor(bytes), "a message between processes");
}

}  // namespace

std::vector<IetRow> measure_specimens(const std::vector<IetSpecimen>& specimens, const std::filesystem::path& folder,
                                      Monitor& monitor) {
  std::vector<IetRow> rows(specimens.size());
  for_each_shared_job(
      specimens.size(), [&](std::size_t i) { return packed(measured_row(specimens[i], folder)); },
      [&](std::size_t i, std::string_view result) { rows[i] = unpacked(result); }, "specimens", monitor);
  mark_outliers(rows);
  return rows;
}

struct IetMeter::Parts {
  IetSpecimen specimen;
  detail::IetModel model;
};

IetMeter::IetMeter(const IetSpecimen& specimen)
    : parts_(std::make_unique<Parts>(Parts{specimen, IetModel(specimen)})) {}

IetMeter::~IetMeter() = default;

IetRow IetMeter::row(const std::vector<Partial>& partials) const {
  const std::vector<Partial> rings = rings_of(partials);
  if (!rings.empty()) return measured_row(parts_->specimen, parts_->model, rings);
  IetRow row = bare_row(parts_->specimen);
  add_remark(row, kNoRing);
  return row;
}

}  // namespace klang::fit
