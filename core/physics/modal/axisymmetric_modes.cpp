#include "core/physics/modal/axisymmetric_modes.hpp"

#include <Spectra/SymGEigsShiftSolver.h>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"

namespace klang::modal {
namespace {

using solid::HarmonicSystem;
using solid::SparseMatrix;
using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>;

/// (K - shift M)^-1, scaled to eigenvalues of order one, and M, as Spectra asks for them.
class Inverse {
 public:
  using Scalar = double;
  Inverse(const Factor& factor, double scale) : factor_(factor), scale_(scale) {}
  Eigen::Index rows() const { return factor_.rows(); }
  Eigen::Index cols() const { return rows(); }
  void set_shift(const double&) {}
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Eigen::VectorXd>(y, rows()) = scale_ * factor_.solve(Eigen::Map<const Eigen::VectorXd>(x, rows()));
  }

 private:
  const Factor& factor_;
  double scale_;
};

class Mass {
 public:
  using Scalar = double;
  explicit Mass(const SparseMatrix& lower) : lower_(lower) {}
  Eigen::Index rows() const { return lower_.rows(); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Eigen::VectorXd>(y, rows()) =
        lower_.selfadjointView<Eigen::Lower>() * Eigen::Map<const Eigen::VectorXd>(x, rows());
  }

 private:
  const SparseMatrix& lower_;
};

double shear_omega(const mesh::Section& section, const solid::Material& material) {
  const double size_m = (section.nodes_m.colwise().maxCoeff() - section.nodes_m.colwise().minCoeff()).norm();
  return kPi * std::sqrt(material.lame_mu_pa / material.density_kg_m3) / size_m;
}

/// Elastic modes of a system below omega^2, by the inertia of K - omega^2 M (Sylvester's law).
int count_below(const HarmonicSystem& system, const SparseMatrix& stiffness, const SparseMatrix& mass,
                double omega_sq) {
  const Factor factor(SparseMatrix(stiffness - omega_sq * mass));
  if (factor.info() != Eigen::Success) throw NumericalError("eigenmodes: the Sturm count met a zero pivot");
  return static_cast<int>((factor.vectorD().array() < 0.0).count()) - static_cast<int>(system.rigid.cols());
}

HarmonicModes solve(const HarmonicSystem& system, const SparseMatrix& stiffness, const SparseMatrix& mass, int count,
                    double shift) {
  HarmonicModes modes;
  modes.vectors.resize(system.n_dofs(), 0);
  if (count <= 0) return modes;
  const int n_rigid = static_cast<int>(system.rigid.cols());
  const auto n_all = static_cast<int>(system.n_dofs());
  if (count + n_rigid >= n_all) throw NumericalError("eigenmodes: more modes wanted than the section has");
  // Two guards: the count that was proven must not be cut inside a cluster.
  const int n = std::min(count + n_rigid + 2, n_all - 1);
  const Factor factor(SparseMatrix(stiffness - shift * mass));
  if (factor.info() != Eigen::Success)
    throw NumericalError("eigenmodes: the shifted stiffness is not positive definite");
  const double scale = -shift;
  Inverse inverse(factor, scale);
  Mass product(mass);
  Spectra::SymGEigsShiftSolver<Inverse, Mass, Spectra::GEigsMode::ShiftInvert> solver(inverse, product, n,
                                                                                      std::min(n_all, 2 * n + 16), 0.0);
  solver.init();
  solver.compute(Spectra::SortRule::LargestAlge, 500, 1e-12);
  if (solver.info() != Spectra::CompInfo::Successful)
    throw NumericalError("eigenmodes: harmonic " + std::to_string(system.harmonic) + " did not converge");
  // One inverse iteration and Rayleigh-Ritz bring all vectors to round-off; rigid motions are told by their subspace.
  Eigen::MatrixXd v = factor.solve(mass.selfadjointView<Eigen::Lower>() * solver.eigenvectors(n));
  const auto project = [&](const SparseMatrix& lower, const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
    return x.transpose() * (lower.selfadjointView<Eigen::Lower>() * x);
  };
  if (n_rigid > 0) {
    const Eigen::MatrixXd gram = project(mass, system.rigid);
    v -= system.rigid * gram.ldlt().solve(system.rigid.transpose() * (mass.selfadjointView<Eigen::Lower>() * v));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(project(mass, v));
  const Eigen::Index n_elastic = n - n_rigid;
  const Eigen::MatrixXd basis = v * (gram.eigenvectors().rightCols(n_elastic) *
                                     gram.eigenvalues().tail(n_elastic).cwiseSqrt().cwiseInverse().asDiagonal());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(project(stiffness, basis));
  modes.angular_frequency_sq = ritz.eigenvalues().head(count);
  modes.vectors = basis * ritz.eigenvectors().leftCols(count);
  const Eigen::MatrixXd ku = stiffness.selfadjointView<Eigen::Lower>() * modes.vectors;
  const Eigen::MatrixXd mu =
      (mass.selfadjointView<Eigen::Lower>() * modes.vectors) * modes.angular_frequency_sq.asDiagonal();
  modes.relative_residual = (ku - mu).colwise().norm().cwiseQuotient(mu.colwise().norm()).transpose();
  return modes;
}

struct Matrices {
  SparseMatrix stiffness, mass;
};

Matrices at_material(const HarmonicSystem& system, const solid::Material& material) {
  return {material.lame_lambda_pa * system.stiffness_lambda + material.lame_mu_pa * system.stiffness_mu,
          material.density_kg_m3 * system.mass_unit_density};
}

}  // namespace

AxisymmetricBody::AxisymmetricBody(mesh::Section section)
    : section_(std::move(section)), volume_m3_(solid::section_volume_m3(section_)) {}

void AxisymmetricBody::extend(std::size_t n) {
  const std::size_t before = systems_.size();
  if (n <= before) return;
  systems_.resize(n);
  parallel_for(n - before, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = before + begin; i < before + end; ++i)
      systems_[i] = solid::assemble_harmonic(section_, i == 0 ? 0 : static_cast<int>(i) - 1, i == 0);
  });
}

std::vector<HarmonicModes> AxisymmetricBody::modes_up_to(const solid::Material& material, double high_hz) {
  const double omega_sq = std::pow(2.0 * kPi * high_hz, 2), shift = -std::pow(0.3 * shear_omega(section_, material), 2);
  std::vector<HarmonicModes> modes;
  int n_empty = 0;
  for (std::size_t next = 0; n_empty < 3;) {
    const std::size_t n = next + 4;
    extend(n);
    modes.resize(n);
    parallel_for(n - next, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = next + begin; i < next + end; ++i) {
        const Matrices at = at_material(systems_[i], material);
        modes[i] =
            solve(systems_[i], at.stiffness, at.mass, count_below(systems_[i], at.stiffness, at.mass, omega_sq), shift);
        if (modes[i].angular_frequency_sq.size() > 0 &&
            !(modes[i].angular_frequency_sq.maxCoeff() <= omega_sq * (1.0 + 1e-9)))
          throw NumericalError("eigenmodes: harmonic " + std::to_string(systems_[i].harmonic) +
                               " misses modes that its count proves");
      }
    });
    for (; next < n; ++next) {
      const bool empty = modes[next].angular_frequency_sq.size() == 0;
      n_empty = empty && systems_[next].harmonic >= 4 ? n_empty + 1 : 0;
    }
  }
  return modes;
}

std::vector<HarmonicModes> AxisymmetricBody::lowest(const solid::Material& material,
                                                    const std::vector<int>& counts) const {
  KLANG_CHECK(counts.size() <= systems_.size(), "lowest: a count for each system that there is");
  const double shift = -std::pow(0.3 * shear_omega(section_, material), 2);
  std::vector<HarmonicModes> modes(counts.size());
  parallel_for(counts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Matrices at = at_material(systems_[i], material);
      modes[i] = solve(systems_[i], at.stiffness, at.mass, counts[i], shift);
    }
  });
  return modes;
}

SampledModes sample_modes(const AxisymmetricBody& body, const std::vector<HarmonicModes>& modes,
                          const mesh::TetMesh& mesh, const solid::Material& material) {
  struct Line {
    double omega_sq;
    int system, index;
    bool turned;
  };
  std::vector<Line> lines;
  for (std::size_t s = 0; s < modes.size(); ++s) {
    for (Eigen::Index k = 0; k < modes[s].angular_frequency_sq.size(); ++k) {
      for (int copy = 0; copy < body.system(s).multiplicity; ++copy)
        lines.push_back({modes[s].angular_frequency_sq[k], static_cast<int>(s), static_cast<int>(k), copy == 1});
    }
  }
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.omega_sq < b.omega_sq; });

  SampledModes sampled;
  sampled.model.mesh = mesh;
  sampled.model.material = material;
  const auto n = static_cast<Eigen::Index>(lines.size());
  sampled.model.angular_frequency_rad_s.resize(n);
  sampled.model.shapes.resize(3 * mesh.n_nodes(), n);
  sampled.relative_residual.resize(n);
  const mesh::SectionLocator locator(body.section());
  std::vector<mesh::SectionLocator::Place> places(static_cast<std::size_t>(mesh.n_nodes()));
  parallel_for(places.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::RowVector3d p = mesh.nodes_m.row(static_cast<Eigen::Index>(i));
      places[i] = locator.find(std::hypot(p.x(), p.y()), p.z());
      if (places[i].element < 0) throw InputError("section", "a mesh node lies outside", std::to_string(i));
    }
  });
  parallel_for(lines.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      const Line& line = lines[l];
      const auto k = static_cast<Eigen::Index>(l);
      const auto s = static_cast<std::size_t>(line.system);
      const auto field = body.system(s).components(modes[s].vectors.col(line.index));
      const double m = body.system(s).harmonic;
      const bool torsion = body.system(s).torsion;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        Eigen::RowVector3d value = Eigen::RowVector3d::Zero();
        for (Eigen::Index c = 0; c < places[i].weight.size(); ++c)
          value += places[i].weight[c] * field.row(body.section().elements(places[i].element, c));
        const double x = mesh.nodes_m(row, 0), y = mesh.nodes_m(row, 1), angle = std::atan2(y, x);
        const double cosine = std::cos(m * angle), sine = std::sin(m * angle);
        const double radial = value[0] * (line.turned ? sine : cosine);
        const double around = torsion ? value[1] : value[1] * (line.turned ? -cosine : sine);
        sampled.model.shapes(3 * row, k) = radial * std::cos(angle) - around * std::sin(angle);
        sampled.model.shapes(3 * row + 1, k) = radial * std::sin(angle) + around * std::cos(angle);
        sampled.model.shapes(3 * row + 2, k) = value[2] * (line.turned ? sine : cosine);
      }
      sampled.model.angular_frequency_rad_s[k] = std::sqrt(line.omega_sq);
      sampled.relative_residual[k] = modes[s].relative_residual[line.index];
    }
  });
  for (const Line& line : lines) {
    sampled.system.push_back(line.system);
    sampled.index.push_back(line.index);
  }
  return sampled;
}

}  // namespace klang::modal
