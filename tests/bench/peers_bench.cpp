// peers_bench CASE [small]: one run of a piece of work by us and by a peer (LAPACK, or what any method must at least pay), as one line
// of JSON: {"ours_s", "peer_s", "difference"}. tools/bench-peers repeats it. The limits:
//   assembly           the assembled matrices' numbers once through memory; difference: the mass of the body
//   eigenmodes         one Cholesky factor of the shifted matrix and one solve per mode; difference: Rayleigh's quotients
//   ringdown           one normal matrix of all partials' amplitudes over all samples (two columns each); difference: frequencies
//   boundary_elements  the dense matrix' LU by LAPACK in double precision; difference: residual of the system
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/la/sparse_cholesky.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/node_ends.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"

extern "C" {
void zgetrf_(const int* m, const int* n, std::complex<double>* a, const int* lda, int* pivots, int* info);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
}

namespace {

using namespace klang;

struct Outcome {
  double ours_s = 0.0, peer_s = 0.0,
         difference = 0.0;  ///< relative; of a limit: our own answer against the exact one or 0
};

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

mesh::TetMesh cube(int cells) {
  const mesh::ShapeSpec shape{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.1}}, {}};
  return mesh::mesh_shape(shape, mesh::ShapeDivisions{{cells, cells, cells}}, 2);
}

/// Normal derivative on the surface by our solver and by QR (zgels) of the systems as printed.
Outcome dual_domain(bool small) {
  using namespace klang::bubble;
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, small ? 0.02 : 0.00498));
  const SourcePoints points = random_source_points(boundary, small ? 10 : 60, small ? 15 : 100, 1);
  const std::vector<SwingingBubble> bubbles{{{0.13, 0.10, -0.05}, 0.0016}};
  Outcome outcome;
  std::vector<DualDomainResult> ours, theirs;
  outcome.ours_s = seconds_of([&] { ours = solve_dual_domain(boundary, 2000.0, points, bubbles, {}); });
  DualDomainOptions printed = DualDomainOptions::as_printed();
  printed.solver = LeastSquares::kDirect;
  theirs = solve_dual_domain(boundary, 2000.0, points, bubbles, printed);
  outcome.peer_s = theirs[0].wall_time_s.at("solve_fluid") + theirs[0].wall_time_s.at("solve_air");
  // The paper's source has the other sign (docs/errata.md).
  const Eigen::VectorXcd& a = ours[0].normal_derivative;
  const Eigen::VectorXcd& b = theirs[0].normal_derivative;
  outcome.difference = std::min((a - b).norm(), (a + b).norm()) / a.norm();
  return outcome;
}

Outcome assembly(bool small) {
  const mesh::TetMesh body = cube(small ? 6 : 20);
  Outcome outcome;
  solid::AssembledSolid assembled;
  outcome.ours_s = seconds_of([&] { assembled = solid::assemble(body); });
  const auto n = static_cast<std::size_t>(assembled.mass_unit_density.nonZeros());
  std::vector<double> numbers(4 * n, 1.0);  // three matrices of numbers, one of places
  outcome.peer_s = seconds_of([&] {
    parallel_for(numbers.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
      std::memset(numbers.data() + begin, 0, (end - begin) * sizeof(double));
    });
  });
  const double total = la::SparseMatrix(assembled.mass_unit_density.selfadjointView<Eigen::Lower>()).sum();
  outcome.difference = std::abs(total / (3.0 * mesh::mesh_volume_m3(body)) - 1.0);
  return outcome;
}

Outcome eigenmodes(bool small) {
  const mesh::TetMesh body = cube(small ? 5 : 10);
  const solid::Material aluminium{4.98e10, 2.57e10, 2700, "", ""};
  const solid::AssembledSolid assembled = solid::assemble(body);
  constexpr int kModes = 50;
  Outcome outcome;
  modal::EigenOptions options;
  options.count = kModes;
  options.estimate_mesh_error = false;
  modal::EigenResult result;
  outcome.ours_s = seconds_of([&] { result = modal::solve_modes(body, assembled, aluminium, {}, options); });
  if (!result.usable()) throw std::runtime_error(result.message);
  const double shift = std::pow(2.0 * kPi * 1000.0, 2) * aluminium.density_kg_m3;
  const la::SparseMatrix matrix =
      solid::stiffness(assembled, aluminium.lame_lambda_pa, aluminium.lame_mu_pa) + shift * assembled.mass_unit_density;
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix.rows(), kModes);
  outcome.peer_s = seconds_of([&] {
    const BlasThreads all(thread_count());
    la::SparseCholesky factor;
    if (!factor.factor(matrix, la::block_ordering(matrix, solid::node_ends(body, assembled))))
      throw std::runtime_error(factor.message());
    factor.solve(right);
  });
  const la::SparseMatrix stiffness =
      solid::stiffness(assembled, aluminium.lame_lambda_pa, aluminium.lame_mu_pa).selfadjointView<Eigen::Lower>();
  for (Eigen::Index mode = 0; mode < result.model.n_modes(); ++mode) {
    const Eigen::VectorXd u = result.model.shapes.col(mode);  // mass-normalised
    const double omega = 2.0 * kPi * result.model.frequency_hz()[mode];
    outcome.difference = std::max(outcome.difference, std::abs(u.dot(stiffness * u) / (omega * omega) - 1.0));
  }
  return outcome;
}

Outcome ringdown(bool small) {
  const int n_partials = small ? 5 : 40;
  const double rate = small ? 16000.0 : 48000.0, duration_s = small ? 0.5 : 6.0;
  audio::Signal bell;
  bell.sample_rate_hz = rate;
  bell.samples = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rate * duration_s), 1);
  RandomStream random(4, 0);
  std::vector<double> given_hz;
  for (int p = 0; p < n_partials; ++p) {
    const double part = static_cast<double>(p) / (n_partials - 1);
    const double f = 180 * std::pow(0.31 * rate / 180, part), decay = 0.5 * std::pow(80.0, part);
    given_hz.push_back(f);
    for (Eigen::Index i = static_cast<Eigen::Index>(0.1 * rate); i < bell.n_frames(); ++i) {
      const double t = static_cast<double>(i) / rate - 0.1;
      bell.samples(i, 0) += 0.05 * std::exp(-decay * t) * std::cos(2 * kPi * f * t + p);
    }
  }
  for (Eigen::Index i = 0; i < bell.n_frames(); ++i) bell.samples(i, 0) += 1e-4 * random.normal();
  Outcome outcome;
  fit::RingdownResult result;
  outcome.ours_s = seconds_of([&] { result = fit::identify_ringdown(bell); });
  for (const double f : given_hz) {
    double nearest = 1.0;
    for (const fit::Partial& partial : result.partials.partials)
      nearest = std::min(nearest, std::abs(partial.frequency_hz / f - 1.0));
    outcome.difference = std::max(outcome.difference, nearest);
  }
  const int n = 2 * n_partials, samples = static_cast<int>(bell.n_frames());
  const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(samples, n);
  Eigen::MatrixXd normal(n, n);
  const double one = 1.0, zero = 0.0;
  outcome.peer_s = seconds_of([&] {
    const BlasThreads all(thread_count());
    dsyrk_("L", "T", &n, &samples, &one, columns.data(), &samples, &zero, normal.data(), &n);
  });
  return outcome;
}

Outcome boundary_elements(bool small) {
  const int divisions = small ? 4 : 12;
  const acoustics::SphereCase sphere{1, 0.1, 0.6 * divisions, divisions};
  Outcome outcome;
  acoustics::SphereResult result;
  outcome.ours_s = seconds_of([&] { result = acoustics::solve_sphere(sphere); });
  if (!result.bem.usable()) throw std::runtime_error(result.bem.message);
  const int n = result.bem.n_unknowns;
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Random(n, n);
  std::vector<int> pivots(static_cast<std::size_t>(n));
  int info = 0;
  outcome.peer_s = seconds_of([&] {
    const BlasThreads all(thread_count());
    zgetrf_(&n, &n, matrix.data(), &n, pivots.data(), &info);
  });
  outcome.difference = result.bem.relative_residual.value();
  return outcome;
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, std::function<Outcome(bool)>> cases = {{"dual_domain", dual_domain},
                                                                     {"assembly", assembly},
                                                                     {"eigenmodes", eigenmodes},
                                                                     {"ringdown", ringdown},
                                                                     {"boundary_elements", boundary_elements}};
  const auto chosen = cases.find(argc > 1 ? argv[1] : "");
  if (chosen == cases.end()) {
    std::fprintf(stderr, "peers_bench CASE [small]; cases:");
    for (const auto& [name, run] : cases) std::fprintf(stderr, " %s", name.c_str());
    std::fprintf(stderr, "\n");
    return 2;
  }
  const Outcome outcome = chosen->second(argc > 2 && std::string(argv[2]) == "small");
  std::printf("{\"ours_s\": %.9g, \"peer_s\": %.9g, \"difference\": %.9g}\n", outcome.ours_s, outcome.peer_s,
              outcome.difference);
  return 0;
}
