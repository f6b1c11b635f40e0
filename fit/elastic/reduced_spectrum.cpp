#include "fit/elastic/reduced_spectrum.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/physics/modal/ellipsoid_solve.hpp"
#include "core/physics/modal/expected_modes.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/modal/revolution_modes.hpp"
#include "core/sound/stage/surface_coupling.hpp"
#include "fit/elastic/elastic_blocks.hpp"

namespace klang::fit {
namespace {

constexpr double kMostFitted = 2000;  ///< of which measured partials could still be told

constexpr double kBasisCut = 1e-6;          // of the largest direction
constexpr double kClusterTolerance = 1e-6;  // relative, of omega^2: derivatives are shared

/// The material with the density that a specimen's mass and a body's volume give, where the mass is known.
/// @throws InputError for a density that no solid has: dimensions in another unit
solid::Material weighed(const Specimen& specimen, solid::Material material, double volume_m3) {
  if (!specimen.mass_kg) return material;
  material.density_kg_m3 = *specimen.mass_kg / volume_m3;
  if (!(material.density_kg_m3 > 1.0 && material.density_kg_m3 < 1e5)) {
    throw InputError("specimen " + specimen.name, "mass and dimensions give an impossible density",
                     to_text(material.density_kg_m3) + " kg/m3", "1 to 1e5 kg/m3");
  }
  return material;
}

void finish_body(const Specimen& specimen, const solid::Material& material, SpecimenBody& body) {
  body.volume_m3 =
      body.section || body.polynomials ? mesh::shape_volume_m3(*specimen.shape) : mesh::mesh_volume_m3(body.mesh);
  body.material = weighed(specimen, material, body.volume_m3);
  body.mass_kg = specimen.mass_kg ? *specimen.mass_kg : material.density_kg_m3 * body.volume_m3;
}

solid::Material with_poissons_ratio(const solid::Material& material, double poissons_ratio) {
  return solid::from_youngs_modulus(material.youngs_modulus_pa(), poissons_ratio, material.density_kg_m3);
}

}  // namespace

SpecimenBody make_body(const Specimen& specimen, const solid::Material& material, double highest_hz) {
  SpecimenBody body;
  if (specimen.shape) {
    solid::Material guess = weighed(specimen, material, shape_volume_m3(*specimen.shape));
    if (material.density_kg_m3 > 0.0) guess.density_kg_m3 = material.density_kg_m3;
    const double bar_speed_m_s = std::sqrt(guess.youngs_modulus_pa() / guess.density_kg_m3);
    body.divisions = mesh::resonance_divisions(*specimen.shape, bar_speed_m_s, highest_hz);
    const auto method = modal::chosen_method({specimen.shape, specimen.support}, {});
    if (method == modal::ModesMethod::kHarmonics)
      body.section = modal::section_divisions_for(*specimen.shape, guess, highest_hz);
    if (method == modal::ModesMethod::kPolynomial &&
        !modal::ellipsoid_axes_m(*specimen.shape)) {  // these go by tetrahedra
      const Eigen::Vector3d half_m = modal::box_half_lengths_m(*specimen.shape);
      body.polynomials =
          modal::box_modes(half_m, *modal::held_faces(specimen.support, half_m), guess, {0.0, highest_hz}).degrees;
    }
    return make_body_like(specimen, material, body);
  }
  mesh::LoadOptions options;
  options.unit_m = specimen.unit_m;
  mesh::BodyNotes notes;
  notes.note = [&body](const std::string& text) { body.notes.push_back(text); };
  body.mesh = mesh::load_body(*specimen.mesh_file, options, &notes);
  finish_body(specimen, material, body);
  return body;
}

SpecimenBody make_body_like(const Specimen& specimen, const solid::Material& material, const SpecimenBody& like) {
  SpecimenBody body;
  body.divisions = like.divisions;
  body.section = like.section;
  body.polynomials = like.polynomials;
  body.shape_dims = specimen.shape->dims;
  body.mesh = mesh::mesh_shape(*specimen.shape, *body.divisions, 2);
  finish_body(specimen, material, body);
  return body;
}

Eigen::VectorXd mode_visibility(const modal::ModalModel& model) {
  const Eigen::VectorXd coupling = stage::surface_coupling(model).cwiseQuotient(model.frequency_hz());
  const double largest = coupling.size() ? coupling.maxCoeff() : 0.0;
  return largest > 0.0 ? Eigen::VectorXd(coupling / largest) : Eigen::VectorXd::Ones(coupling.size());
}

ReducedSpectrum::ReducedSpectrum(const Specimen& specimen, const SpecimenBody& body,
                                 const std::vector<std::string>& free_dimensions, const ReducedSpectrumOptions& options,
                                 Monitor& monitor)
    : mass_kg_(specimen.mass_kg) {
  validate_fields("reduced spectrum", options);
  const double expected = modal::expected_modes(modal::size_of(body.mesh), body.material, options.band.high_hz);
  const double unknowns = body.section || body.polynomials ? expected : 3.0 * body.mesh.n_nodes();
  modal::check_expected_modes("specimen " + specimen.name, std::min(expected, unknowns), options.band.high_hz,
                              kMostFitted);
  const auto system = detail::elastic_blocks(specimen, body, 0, monitor);
  // Where material ratio or shape change, the modes at the solution are solved for and proven then.
  auto lowest = system->lowest(body.material, options, !options.vary_ratio && free_dimensions.empty());
  nominal_ = std::move(lowest.result);
  const auto n_all = static_cast<int>(nominal_.model.n_modes());
  n_skipped_ = static_cast<int>((nominal_.model.frequency_hz().array() < options.band.low_hz).count());
  n_modes_ = n_all - n_skipped_;
  if (n_modes_ < 1) throw NumericalError("specimen " + specimen.name + ": no mode in the band");
  {
    modal::ModalModel& model = nominal_.model;
    model.angular_frequency_rad_s = model.angular_frequency_rad_s.segment(n_skipped_, n_modes_).eval();
    model.shapes = model.shapes.middleCols(n_skipped_, n_modes_).eval();
    nominal_.relative_residual = nominal_.relative_residual.segment(n_skipped_, n_modes_).eval();
    relative_error_ = lowest.relative_error.segment(n_skipped_, n_modes_);
  }
  visibility_ = mode_visibility(nominal_.model);
  BlockVectors vectors;
  vectors.push_back(std::move(lowest.vectors));
  std::vector<int> counts;
  for (const auto& block : vectors.front()) counts.push_back(static_cast<int>(block.cols()));
  n_blocks_ = counts.size();
  if (options.vary_ratio) {
    // One anchor on the far side: eigenvalue errors between the two are of fourth order in what mode shapes change.
    const double anchor_ratio = body.material.poissons_ratio() > 0.27 ? 0.12 : 0.42;
    vectors.push_back(system->vectors(with_poissons_ratio(body.material, anchor_ratio), counts));
  }
  log_volume_ = std::log(body.volume_m3);
  const Changed changed = changed_about(specimen, body, free_dimensions, options, monitor, axes_);
  for (const auto& blocks : changed.blocks) vectors.push_back(blocks->vectors(body.material, counts));
  if (options.watch_given && specimen.shape && specimen.shape->kind != "revolution") {
    for (const auto& [dimension, value] : specimen.shape->dims) {
      if (std::find(free_dimensions.begin(), free_dimensions.end(), dimension) == free_dimensions.end())
        given_names_.push_back(dimension);
    }
  }
  ReducedSpectrumOptions slopes_only =
      options;  // a short step leaves less in central differences; curvature is not asked for
  slopes_only.relative_step = std::min(options.relative_step, 1e-3);
  const Changed watched = changed_about(specimen, body, given_names_, slopes_only, monitor, given_);
  for (std::size_t b = 0; b < counts.size(); ++b) {
    Block block;
    block.multiplicity = system->multiplicity(b);
    block.n_modes = counts[b];
    if (block.n_modes == 0) {
      for (auto* axes : {&axes_, &given_}) {
        for (Axis& axis : *axes) axis.slope.emplace_back(), axis.curvature.emplace_back();
      }
    } else {
      Eigen::MatrixXd rigid;
      if (!changed.blocks.empty() || !watched.blocks.empty()) {
        rigid = system->rigid_motions(b);
        block.n_rigid = rigid.cols();
        for (const auto* others : {&changed, &watched})
          for (const auto& blocks : others->blocks) {
            const Eigen::MatrixXd more = blocks->rigid_motions(b);
            if (more.cols() == 0) continue;
            rigid.conservativeResize(more.rows(), rigid.cols() + more.cols());
            rigid.rightCols(more.cols()) = more;
          }
      }
      const Projection onto = projection(*system, b, counts[b], vectors, rigid, lowest.correction);
      block.centre = onto.matrices(*system, b);
      for (std::size_t a = 0; a < axes_.size(); ++a)
        axes_[a].add_block(onto.matrices(*changed.blocks[2 * a], b), block.centre,
                           onto.matrices(*changed.blocks[2 * a + 1], b));
      for (std::size_t a = 0; a < given_.size(); ++a)
        given_[a].add_block(onto.matrices(*watched.blocks[2 * a], b), block.centre,
                            onto.matrices(*watched.blocks[2 * a + 1], b));
    }
    blocks_.push_back(std::move(block));
  }
  order_ = order_at_start(body.material);
}

ReducedSpectrum::Changed ReducedSpectrum::changed_about(const Specimen& specimen, const SpecimenBody& body,
                                                        const std::vector<std::string>& dimensions,
                                                        const ReducedSpectrumOptions& options, Monitor& monitor,
                                                        std::vector<Axis>& axes) const {
  Changed changed;
  changed.bodies.reserve(2 * dimensions.size());
  const std::size_t n_blocks = body.section ? n_blocks_ : 0;
  for (const std::string& dimension : dimensions) {
    Axis axis;
    axis.start_m = specimen.shape->dims.at(dimension);
    axis.step = options.relative_step;
    for (const double sign : {-1.0, 1.0}) {
      Specimen other = specimen;
      other.shape->dims[dimension] = axis.start_m * std::exp(sign * axis.step);
      mesh::validate(*other.shape);
      changed.bodies.push_back(make_body_like(other, body.material, body));
      changed.blocks.push_back(detail::elastic_blocks(other, changed.bodies.back(), n_blocks, monitor));
    }
    const double h = axis.step, low = std::log(changed.bodies[changed.bodies.size() - 2].volume_m3),
                 high = std::log(changed.bodies.back().volume_m3);
    axis.volume_slope = (high - low) / (2.0 * h);
    axis.volume_curvature = (high - 2.0 * log_volume_ + low) / (2.0 * h * h);
    axes.push_back(std::move(axis));
  }
  return changed;
}

ReducedSpectrum::Matrices ReducedSpectrum::matrices_at(const SpectrumPoint& point, std::size_t block) const {
  Matrices sum = blocks_[block].centre;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const double t = std::log(point.dimensions[a] / axes_[a].start_m);
    const Matrices &s = axes_[a].slope[block], &c = axes_[a].curvature[block];
    sum.stiffness_lambda += t * s.stiffness_lambda + t * t * c.stiffness_lambda;
    sum.stiffness_mu += t * s.stiffness_mu + t * t * c.stiffness_mu;
    sum.mass += t * s.mass + t * t * c.mass;
  }
  return sum;
}

Eigen::MatrixXd ReducedSpectrum::given_slopes(const SpectrumPoint& point) const {
  const double lambda = point.lame_lambda_pa, mu = point.lame_mu_pa, density = density_kg_m3(point);
  const auto n_given = static_cast<Eigen::Index>(given_.size());
  Eigen::Index n_lines = 0, line = 0;
  for (const Block& block : blocks_) n_lines += block.multiplicity * block.n_modes;
  Eigen::MatrixXd all(n_lines, n_given);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Eigen::Index n = blocks_[b].n_modes;
    if (n == 0) continue;
    const Matrices at = matrices_at(point, b);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pairs(
        lambda * at.stiffness_lambda + mu * at.stiffness_mu, density * at.mass);
    const Eigen::MatrixXd u = pairs.eigenvectors().middleCols(blocks_[b].n_rigid, n);
    Eigen::MatrixXd slopes(n, n_given);
    for (Eigen::Index g = 0; g < n_given; ++g) {
      const Axis& axis = item(given_, g);
      const Matrices& s = axis.slope[b];
      const Eigen::MatrixXd stiffness = lambda * s.stiffness_lambda + mu * s.stiffness_mu;
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto shape = u.col(k);
        slopes(k, g) = 0.5 * (shape.dot(stiffness * shape) / pairs.eigenvalues()[blocks_[b].n_rigid + k] -
                              density * shape.dot(s.mass * shape) + (mass_kg_ ? axis.volume_slope : 0.0));
      }
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      for (int copy = 0; copy < blocks_[b].multiplicity; ++copy) all.row(line++) = slopes.row(k);
    }
  }
  return all(order_, Eigen::all);
}

ReducedSpectrum::Matrices ReducedSpectrum::Projection::matrices(const detail::ElasticBlocks& from,
                                                                std::size_t block) const {
  auto p = from.projected(block, basis);
  return {softer.transpose() * p.stiffness_lambda * softer, softer.transpose() * p.stiffness_mu * softer,
          std::move(p.mass)};
}

ReducedSpectrum::Projection ReducedSpectrum::projection(const detail::ElasticBlocks& system, std::size_t block,
                                                        Eigen::Index n_modes, const BlockVectors& vectors,
                                                        const Eigen::MatrixXd& rigid,
                                                        const std::vector<Eigen::VectorXd>& correction) {
  const auto n_vectors = n_modes * static_cast<Eigen::Index>(vectors.size());
  Eigen::MatrixXd collected(vectors.front()[block].rows(), n_vectors + rigid.cols());
  for (std::size_t v = 0; v < vectors.size(); ++v)
    collected.middleCols(static_cast<Eigen::Index>(v) * n_modes, n_modes) = vectors[v][block];
  // As long as a mode, so that the cut below treats them alike.
  for (Eigen::Index r = 0; r < rigid.cols(); ++r)
    collected.col(n_vectors + r) = rigid.col(r) * (collected.col(0).norm() / rigid.col(r).norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(system.projected_mass(block, collected));
  const auto& weight = gram.eigenvalues();
  const Eigen::Index rank = (weight.array() > kBasisCut * kBasisCut * weight[weight.size() - 1]).count();
  Projection onto;
  onto.basis =
      collected * (gram.eigenvectors().rightCols(rank) * weight.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal());
  // Known mesh errors are taken out of both stiffnesses mode by mode: T^T K T with T = 1 - sum error u u^T M.
  onto.softer = Eigen::MatrixXd::Identity(rank, rank);
  if (!correction.empty()) {
    // The basis is orthonormal with unit density: coordinates of the collected vectors are roots of their Gram matrix.
    Eigen::MatrixXd u =
        weight.tail(rank).cwiseSqrt().asDiagonal() * gram.eigenvectors().rightCols(rank).transpose().leftCols(n_modes);
    u.colwise().normalize();
    onto.softer -= u * correction[block].asDiagonal() * u.transpose();
  }
  return onto;
}

void ReducedSpectrum::Axis::add_block(const Matrices& low, const Matrices& centre, const Matrices& high) {
  const double h = step;
  const auto by_step = [&](const auto& l, const auto& u) { return ((u - l) / (2.0 * h)).eval(); };
  const auto bend = [&](const auto& l, const auto& c, const auto& u) {
    return ((u - 2.0 * c + l) / (2.0 * h * h)).eval();
  };
  slope.push_back({by_step(low.stiffness_lambda, high.stiffness_lambda), by_step(low.stiffness_mu, high.stiffness_mu),
                   by_step(low.mass, high.mass)});
  curvature.push_back({bend(low.stiffness_lambda, centre.stiffness_lambda, high.stiffness_lambda),
                       bend(low.stiffness_mu, centre.stiffness_mu, high.stiffness_mu),
                       bend(low.mass, centre.mass, high.mass)});
}

std::vector<Eigen::Index> ReducedSpectrum::order_at_start(const solid::Material& material) const {
  std::vector<std::pair<double, Eigen::Index>> lines;
  for (const Block& block : blocks_) {
    if (block.n_modes == 0) continue;
    const Matrices& c = block.centre;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pairs(
        material.lame_lambda_pa * c.stiffness_lambda + material.lame_mu_pa * c.stiffness_mu, c.mass,
        Eigen::EigenvaluesOnly);
    for (Eigen::Index k = 0; k < block.n_modes; ++k) {
      for (int copy = 0; copy < block.multiplicity; ++copy)
        lines.emplace_back(pairs.eigenvalues()[block.n_rigid + k], static_cast<Eigen::Index>(lines.size()));
    }
  }
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::Index> order;
  for (int k = n_skipped_; k < n_skipped_ + n_modes_; ++k) order.push_back(item(lines, k).second);
  return order;
}

double ReducedSpectrum::log_volume(const SpectrumPoint& point, Eigen::VectorXd* gradient) const {
  double value = log_volume_;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const double t = std::log(point.dimensions[a] / axes_[a].start_m);
    value += t * axes_[a].volume_slope + t * t * axes_[a].volume_curvature;
    if (gradient) {
      (*gradient)[static_cast<Eigen::Index>(a)] =
          (axes_[a].volume_slope + 2.0 * t * axes_[a].volume_curvature) / point.dimensions[a];
    }
  }
  return value;
}

double ReducedSpectrum::density_kg_m3(const SpectrumPoint& point) const {
  return mass_kg_ ? *mass_kg_ / std::exp(log_volume(point, nullptr)) : point.density_kg_m3;
}

Spectrum ReducedSpectrum::spectrum(const SpectrumPoint& point) const {
  const auto n_axes = static_cast<Eigen::Index>(axes_.size());
  const double lambda = point.lame_lambda_pa, mu = point.lame_mu_pa;
  Eigen::VectorXd volume_slope = Eigen::VectorXd::Zero(n_axes);
  log_volume(point, &volume_slope);
  const double density = density_kg_m3(point);
  Eigen::Index n_lines = 0;
  for (const Block& block : blocks_) n_lines += block.multiplicity * block.n_modes;
  Eigen::VectorXd all_values(n_lines);
  Eigen::MatrixXd all_slopes = Eigen::MatrixXd::Zero(n_lines, 3 + n_axes);
  Eigen::Index line = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    const Eigen::Index n = block.n_modes;
    if (n == 0) continue;
    const Matrices at = matrices_at(point, b);
    const Eigen::MatrixXd &k_lambda = at.stiffness_lambda, &k_mu = at.stiffness_mu, &mass = at.mass;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pairs(lambda * k_lambda + mu * k_mu,
                                                                          density * mass);
    const Eigen::VectorXd value = pairs.eigenvalues().segment(block.n_rigid, n);
    const Eigen::MatrixXd u = pairs.eigenvectors().middleCols(block.n_rigid, n);  // u^T (rho M) u = 1
    const auto quadratic = [&](const Eigen::MatrixXd& a) -> Eigen::VectorXd {
      return u.cwiseProduct(a * u).colwise().sum().transpose();
    };
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(n, 3 + n_axes);
    slopes.col(0) = quadratic(k_lambda).cwiseQuotient(value);
    slopes.col(1) = quadratic(k_mu).cwiseQuotient(value);
    if (!mass_kg_) slopes.col(2).setConstant(-1.0);
    for (Eigen::Index a = 0; a < n_axes; ++a) {
      const Axis& axis = item(axes_, a);
      const Matrices &s = axis.slope[b], &c = axis.curvature[b];
      const double at_m = item(point.dimensions, a);
      const double t = std::log(at_m / axis.start_m);
      const Eigen::MatrixXd k_slope = lambda * (s.stiffness_lambda + 2.0 * t * c.stiffness_lambda) +
                                      mu * (s.stiffness_mu + 2.0 * t * c.stiffness_mu);
      const Eigen::MatrixXd m_slope = density * (s.mass + 2.0 * t * c.mass);
      slopes.col(3 + a) = (quadratic(k_slope).cwiseQuotient(value) - quadratic(m_slope)) / at_m;
      if (mass_kg_) slopes.col(3 + a).array() += volume_slope[a];
    }
    for (Eigen::Index first = 0; first < n;) {  // equal eigenvalues of a block share the mean of their derivatives
      Eigen::Index last = first;
      while (last + 1 < n && value[last + 1] - value[last] <= kClusterTolerance * value[last + 1]) ++last;
      const Eigen::RowVectorXd mean = slopes.middleRows(first, last - first + 1).colwise().mean();
      slopes.middleRows(first, last - first + 1).rowwise() = mean;
      first = last + 1;
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      for (int copy = 0; copy < block.multiplicity; ++copy, ++line) {
        all_values[line] = value[k];
        all_slopes.row(line) = slopes.row(k);
      }
    }
  }
  Spectrum spectrum;
  spectrum.log_angular_frequency_sq = all_values(order_).array().log();
  spectrum.derivative = all_slopes(order_, Eigen::all);
  return spectrum;
}

}  // namespace klang::fit
