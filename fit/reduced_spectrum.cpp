#include "fit/reduced_spectrum.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/errors.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/quality.hpp"
#include "core/modal/oscillator_bank.hpp"

namespace klang::fit {
namespace {

constexpr double kBasisCut = 1e-6;          // of the largest direction
constexpr double kClusterTolerance = 1e-6;  // relative, of omega^2: derivatives are shared

int even_between(double count, int low, int high) {
  return 2 * ((std::clamp(static_cast<int>(std::ceil(count)), low, high) + 1) / 2);
}

/// Divisions that keep the mesh's own error of the frequencies up to highest_hz near 0.1 % (one tenth of what the
/// dimensions of a real body leave open) at some ten thousand nodes. Found by refinement studies of each kind: the
/// sweep's own default resolves the lowest bending only.
mesh::ShapeDivisions fit_divisions(const mesh::ShapeSpec& shape, const solid::Material& material, double highest_hz) {
  mesh::ShapeDivisions divisions = mesh::shape_divisions(shape, {});
  auto& n = divisions.counts;
  if (shape.kind == "tube") {
    // Ring modes (the section turns oval) need twice the elements around; below them bending rules.
    const double radius_m = shape.dims.at("outer_radius_m") - 0.5 * shape.dims.at("wall_m");
    const double speed = std::sqrt(material.youngs_modulus_pa() / material.density_kg_m3);
    const double ring_hz = 2.683 / (2.0 * kPi) * shape.dims.at("wall_m") / (std::sqrt(12.0) * radius_m * radius_m) * speed;
    n[0] = std::min(n[0], 36);
    n[1] = std::max(n[1], highest_hz > ring_hz ? 40 : 24);
  } else if (shape.kind == "rod") {
    n = {std::min(n[0], 30), 2, 2};
  } else if (shape.kind == "box") {
    const std::array<double, 3> sides = {shape.dims.at("length_m"), shape.dims.at("width_m"), shape.dims.at("height_m")};
    std::array<std::size_t, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sides[a] < sides[b]; });
    const double thin = sides[order[0]], middle = sides[order[1]], longest = sides[order[2]];
    if (thin < 0.35 * longest) {  // a bar or plate: torsion bends the shear around its edges
      const bool plate = middle > 0.5 * longest;
      n[order[0]] = plate || middle > 6.0 * thin ? 2 : 4;
      n[order[1]] = even_between(middle / (plate ? 0.65 * thin : 0.45 * thin), plate ? 10 : 4, plate ? 20 : 16);
      n[order[2]] = even_between(longest / (0.65 * thin), plate ? 10 : 16, plate ? 20 : 48);
    }
  } else if (shape.kind == "bowl") {
    n = {std::max(n[0], 10), std::max(n[1], 10), n[2]};
  } else if (shape.kind == "revolution") {
    n[0] = std::max(n[0], 36);
  }
  return divisions;
}

void finish_body(const Specimen& specimen, const solid::Material& material, SpecimenBody& body) {
  body.volume_m3 = mesh::mesh_volume_m3(body.mesh);
  body.material = material;
  if (specimen.mass_kg) {
    body.mass_kg = *specimen.mass_kg;
    body.material.density_kg_m3 = body.mass_kg / body.volume_m3;
    if (!(body.material.density_kg_m3 > 1.0 && body.material.density_kg_m3 < 1e5)) {
      throw InputError("specimen " + specimen.name, "mass and dimensions give an impossible density",
                       to_text(body.material.density_kg_m3) + " kg/m3", "1 to 1e5 kg/m3");
    }
  } else {
    body.mass_kg = material.density_kg_m3 * body.volume_m3;
  }
}

Eigen::MatrixXd free_rows(const Eigen::MatrixXd& shapes, const solid::AssembledSolid& assembled) {
  Eigen::MatrixXd rows(assembled.n_dofs(), shapes.cols());
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = shapes.middleRows<3>(3 * assembled.free_nodes[i]);
  }
  return rows;
}

Eigen::MatrixXd projected(const solid::SparseMatrix& lower, const Eigen::MatrixXd& basis) {
  const Eigen::MatrixXd image = lower.selfadjointView<Eigen::Lower>() * basis;
  const Eigen::MatrixXd product = basis.transpose() * image;
  return 0.5 * (product + product.transpose());
}

solid::Material with_poissons_ratio(const solid::Material& material, double poissons_ratio) {
  return solid::from_youngs_modulus(material.youngs_modulus_pa(), poissons_ratio, material.density_kg_m3);
}

}  // namespace

SpecimenBody make_body(const Specimen& specimen, const solid::Material& material, double highest_hz) {
  SpecimenBody body;
  if (specimen.shape) {
    solid::Material guess = material;
    if (!(guess.density_kg_m3 > 0.0)) guess.density_kg_m3 = *specimen.mass_kg / shape_volume_m3(*specimen.shape);
    const auto divisions = fit_divisions(*specimen.shape, guess, highest_hz);
    return make_body(specimen, material, divisions);
  }
  mesh::LoadOptions options;
  body.mesh = mesh::load_body(*specimen.mesh_file, options);
  finish_body(specimen, material, body);
  return body;
}

SpecimenBody make_body(const Specimen& specimen, const solid::Material& material,
                       const mesh::ShapeDivisions& divisions) {
  SpecimenBody body;
  body.divisions = divisions;
  body.shape_dims = specimen.shape->dims;
  body.mesh = mesh::mesh_shape(*specimen.shape, divisions, 2);
  finish_body(specimen, material, body);
  return body;
}

Eigen::VectorXd mode_visibility(const modal::ModalModel& model) {
  const Eigen::VectorXd coupling = modal::surface_coupling(model).cwiseQuotient(model.frequency_hz());
  const double largest = coupling.size() ? coupling.maxCoeff() : 0.0;
  return largest > 0.0 ? Eigen::VectorXd(coupling / largest) : Eigen::VectorXd::Ones(coupling.size());
}

ReducedSpectrum::ReducedSpectrum(const Specimen& specimen, const SpecimenBody& body,
                                 const std::vector<std::string>& free_dimensions,
                                 const ReducedSpectrumOptions& options, Monitor& monitor)
    : mass_kg_(specimen.mass_kg) {
  const auto solve = [&](const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                         const solid::Material& material, int count, bool prove) {
    modal::EigenOptions eigen;
    eigen.count = count;
    eigen.band.low_hz = 0.0;
    eigen.prove_none_missing = prove;
    auto result = modal::solve_modes(mesh, assembled, material, specimen.support, eigen, monitor);
    if (!result.usable()) throw NumericalError("specimen " + specimen.name + ": " + result.message);
    return result;
  };
  const auto assembled = solid::assemble(body.mesh, specimen.support);
  // Free modes are fewer than the degrees of freedom; tiny meshes must not be asked for more.
  const int most = std::max(1, std::min(options.max_count, static_cast<int>(assembled.n_dofs()) / 3 - 6));
  // Where material ratio or shape change, the modes at the solution are solved for and proven then.
  const bool prove = !options.vary_ratio && free_dimensions.empty();
  int count = options.count > 0 ? std::min(options.count, most) : std::min(24, most);
  nominal_ = solve(body.mesh, assembled, body.material, count, prove);
  const auto highest_hz = [&] { return nominal_.model.frequency_hz()[nominal_.model.n_modes() - 1]; };
  if (options.count == 0 && count < most && highest_hz() < options.band.high_hz) {
    // Mode counts grow like f (plates) to f^3 (solids); between them f^1.5 is enough in most cases.
    const double ratio = std::min(options.band.high_hz / highest_hz(), 10.0);
    count = std::min(most, static_cast<int>(std::ceil(1.15 * count * std::pow(ratio, 1.5))) + 4);
    nominal_ = solve(body.mesh, assembled, body.material, count, prove);
  }
  if (options.count == 0) {  // those beyond the band are of no use
    const auto useful = (nominal_.model.frequency_hz().array() <= 1.02 * options.band.high_hz).count() + 2;
    count = std::max<int>(std::min<int>(count, static_cast<int>(useful)), 1);
  }
  n_skipped_ = static_cast<int>((nominal_.model.frequency_hz().array() < options.band.low_hz).count());
  n_modes_ = count - n_skipped_;
  if (n_modes_ < 1) throw NumericalError("specimen " + specimen.name + ": no mode in the band");
  std::vector<Eigen::MatrixXd> modes = {free_rows(nominal_.model.shapes, assembled)};
  {
    modal::ModalModel& model = nominal_.model;
    model.angular_frequency_rad_s = model.angular_frequency_rad_s.segment(n_skipped_, n_modes_).eval();
    model.shapes = model.shapes.middleCols(n_skipped_, n_modes_).eval();
    nominal_.relative_residual = nominal_.relative_residual.segment(n_skipped_, n_modes_).eval();
  }
  visibility_ = mode_visibility(nominal_.model);
  if (options.vary_ratio) {
    // One anchor on the far side: eigenvalue errors between the two are of fourth order in what mode shapes change.
    const double anchor_ratio = body.material.poissons_ratio() > 0.27 ? 0.12 : 0.42;
    const auto anchor = solve(body.mesh, assembled, with_poissons_ratio(body.material, anchor_ratio), count, false);
    modes.push_back(free_rows(anchor.model.shapes, assembled));
  }

  struct Sample {
    solid::AssembledSolid assembled;
    double log_volume;
  };
  std::vector<Sample> samples;
  for (const std::string& dimension : free_dimensions) {
    Axis axis;
    axis.start_m = specimen.shape->dims.at(dimension);
    axis.step = options.relative_step;
    for (const double sign : {-1.0, 1.0}) {
      Specimen changed = specimen;
      changed.shape->dims[dimension] = axis.start_m * std::exp(sign * axis.step);
      mesh::validate(*changed.shape);
      const SpecimenBody other = make_body(changed, body.material, *body.divisions);
      samples.push_back({solid::assemble(other.mesh, specimen.support), std::log(other.volume_m3)});
      modes.push_back(
          free_rows(solve(other.mesh, samples.back().assembled, body.material, count, false).model.shapes, assembled));
    }
    axes_.push_back(std::move(axis));
  }
  Eigen::Index n_columns = 0;
  for (const auto& block : modes) n_columns += block.cols();
  Eigen::MatrixXd collected(assembled.n_dofs(), n_columns);
  n_columns = 0;
  for (const auto& block : modes) {
    collected.middleCols(n_columns, block.cols()) = block;
    n_columns += block.cols();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(projected(assembled.mass_unit_density, collected));
  const auto& weight = gram.eigenvalues();
  const Eigen::Index rank = (weight.array() > kBasisCut * kBasisCut * weight[weight.size() - 1]).count();
  const Eigen::MatrixXd basis = collected * (gram.eigenvectors().rightCols(rank) *
                                             weight.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal());
  const auto matrices = [&](const solid::AssembledSolid& solid, double volume) {
    return Matrices{projected(solid.stiffness_lambda, basis), projected(solid.stiffness_mu, basis),
                    projected(solid.mass_unit_density, basis), volume};
  };
  centre_ = matrices(assembled, std::log(body.volume_m3));
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const Matrices low = matrices(samples[2 * a].assembled, samples[2 * a].log_volume);
    const Matrices high = matrices(samples[2 * a + 1].assembled, samples[2 * a + 1].log_volume);
    const double h = axes_[a].step;
    const auto slope = [&](const auto& l, const auto& u) { return ((u - l) / (2.0 * h)).eval(); };
    const auto bend = [&](const auto& l, const auto& c, const auto& u) {
      return ((u - 2.0 * c + l) / (2.0 * h * h)).eval();
    };
    axes_[a].slope = {slope(low.stiffness_lambda, high.stiffness_lambda), slope(low.stiffness_mu, high.stiffness_mu),
                      slope(low.mass, high.mass), (high.log_volume - low.log_volume) / (2.0 * h)};
    axes_[a].curvature = {bend(low.stiffness_lambda, centre_.stiffness_lambda, high.stiffness_lambda),
                          bend(low.stiffness_mu, centre_.stiffness_mu, high.stiffness_mu),
                          bend(low.mass, centre_.mass, high.mass),
                          (high.log_volume - 2.0 * centre_.log_volume + low.log_volume) / (2.0 * h * h)};
  }
}

double ReducedSpectrum::log_volume(const SpectrumPoint& point, Eigen::VectorXd* gradient) const {
  double value = centre_.log_volume;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const double t = std::log(point.dimensions[a] / axes_[a].start_m);
    value += t * axes_[a].slope.log_volume + t * t * axes_[a].curvature.log_volume;
    if (gradient) {
      (*gradient)[static_cast<Eigen::Index>(a)] =
          (axes_[a].slope.log_volume + 2.0 * t * axes_[a].curvature.log_volume) / point.dimensions[a];
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
  Eigen::MatrixXd k_lambda = centre_.stiffness_lambda, k_mu = centre_.stiffness_mu, mass = centre_.mass;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const double t = std::log(point.dimensions[a] / axes_[a].start_m);
    const Matrices &s = axes_[a].slope, &c = axes_[a].curvature;
    k_lambda += t * s.stiffness_lambda + t * t * c.stiffness_lambda;
    k_mu += t * s.stiffness_mu + t * t * c.stiffness_mu;
    mass += t * s.mass + t * t * c.mass;
  }
  const double density = density_kg_m3(point);
  const Eigen::MatrixXd stiffness = lambda * k_lambda + mu * k_mu;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pairs(stiffness, density * mass);
  const Eigen::Index n = n_modes_;
  const Eigen::VectorXd value = pairs.eigenvalues().segment(n_skipped_, n);
  const Eigen::MatrixXd u = pairs.eigenvectors().middleCols(n_skipped_, n);  // u^T (rho M) u = 1
  const auto quadratic = [&](const Eigen::MatrixXd& a) -> Eigen::VectorXd {
    return u.cwiseProduct(a * u).colwise().sum().transpose();
  };
  Spectrum spectrum;
  spectrum.log_angular_frequency_sq = value.array().log();
  spectrum.derivative.setZero(n, 3 + n_axes);
  spectrum.derivative.col(0) = quadratic(k_lambda).cwiseQuotient(value);
  spectrum.derivative.col(1) = quadratic(k_mu).cwiseQuotient(value);
  if (!mass_kg_) spectrum.derivative.col(2).setConstant(-1.0);
  for (Eigen::Index a = 0; a < n_axes; ++a) {
    const Axis& axis = axes_[static_cast<std::size_t>(a)];
    const double at_m = point.dimensions[static_cast<std::size_t>(a)];
    const double t = std::log(at_m / axis.start_m);
    const Eigen::MatrixXd k_slope = lambda * (axis.slope.stiffness_lambda + 2.0 * t * axis.curvature.stiffness_lambda) +
                                    mu * (axis.slope.stiffness_mu + 2.0 * t * axis.curvature.stiffness_mu);
    const Eigen::MatrixXd m_slope = density * (axis.slope.mass + 2.0 * t * axis.curvature.mass);
    spectrum.derivative.col(3 + a) = (quadratic(k_slope).cwiseQuotient(value) - quadratic(m_slope)) / at_m;
    if (mass_kg_) spectrum.derivative.col(3 + a).array() += volume_slope[a];
  }
  for (Eigen::Index first = 0; first < n;) {  // equal eigenvalues share the mean of their derivatives
    Eigen::Index last = first;
    while (last + 1 < n && value[last + 1] - value[last] <= kClusterTolerance * value[last + 1]) ++last;
    const Eigen::RowVectorXd mean = spectrum.derivative.middleRows(first, last - first + 1).colwise().mean();
    spectrum.derivative.middleRows(first, last - first + 1).rowwise() = mean;
    first = last + 1;
  }
  return spectrum;
}

}  // namespace klang::fit
