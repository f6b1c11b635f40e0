#pragma once
#include <map>
#include <optional>
#include <string>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::modal {

enum class EigenMethod { kAuto, kDense, kShiftInvert, kHarmonics, kPolynomials };
enum class EigenStatus { kNotRun, kConverged, kNotConverged, kFailed };

struct EigenOptions {
  int count = 0;  ///< elastic modes wanted from the lowest up; 0: all within the band
  Band band;      ///< modes outside are not returned; with count > 0 only low_hz counts
  int most = 0;   ///< with count 0: where the band holds more than these, the lowest of them only; 0: all
  EigenMethod method = EigenMethod::
      kAuto;  ///< kAuto: dense below dense_limit_nodes free nodes; kHarmonics and kPolynomials are for solve_revolution_modes and solve_box_modes to report
  int dense_limit_nodes = 250;  // a dense solve of 1000 nodes takes 50 times the sparse one's time
  double tolerance = 1e-10;     ///< relative residual ||K u - w^2 M u|| / (w^2 ||M u||), 1e-14 to 1e-3
  int max_restarts = 300;
  bool prove_none_missing = true;    ///< Sturm count above the last mode
  bool estimate_mesh_error = false;  ///< modal/mesh_error.hpp; costs a fifth to a quarter of the rest
  void validate() const;             ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"count", "Elastic modes from the lowest up; 0: all within the band", at_least(0.0)}, self.count);
    visit({"band.low_hz", "Lowest frequency of a mode that is returned", between(0.0, 1e12)}, self.band.low_hz);
    visit({"most", "With count 0, the lowest of the band only; 0: all", at_least(0.0)}, self.most);
    visit({"dense_limit_nodes", "Bodies of fewer free nodes are solved densely", at_least(0.0)},
          self.dense_limit_nodes);
    visit({"tolerance", "Relative residual of a mode", between(1e-14, 1e-3)}, self.tolerance);
    visit({"max_restarts", "Restarts of the block Lanczos process at most", at_least(1.0)}, self.max_restarts);
    visit({"prove_none_missing", "Count the modes below the last one by Sturm's theorem"}, self.prove_none_missing);
    visit({"estimate_mesh_error", "Estimate what the mesh leaves out"}, self.estimate_mesh_error);
  }
};

struct EigenResult {
  EigenStatus status = EigenStatus::kNotRun;
  std::string message;
  ModalModel model;                                    ///< mesh, material and support as given
  Eigen::VectorXd relative_residual;                   ///< n_modes
  std::optional<Eigen::VectorXd> mesh_relative_error;  ///< n_modes, estimate of (f_h - f) / f; empty: not asked for
  int n_rigid_modes = 0;                               ///< 6 for a free connected body, 0 when clamped
  int n_below_band = 0;                                ///< elastic modes under band.low_hz, which are left out
  int n_left_out = 0;                                  ///< within the band, above the lowest EigenOptions::most
  std::optional<bool> none_missing;                    ///< true: proven; false: the count disagrees; empty: not checked
  std::optional<long> sturm_count;                     ///< eigenvalues below the check frequency, rigid ones included
  EigenMethod method_used = EigenMethod::kAuto;
  int n_operations = 0;                       ///< shift-invert solves
  std::map<std::string, double> wall_time_s;  ///< "factor", "iterate", "sturm" (may overlap), "mesh_error", "total"
  bool usable() const { return status == EigenStatus::kConverged; }
};

/// Elastic eigenmodes of K u = omega^2 M u. Rigid modes are found by their known subspace (translations and
/// rotations of each connected part that the support leaves free) and projected out, not told apart by a
/// threshold.
EigenResult solve_modes(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                        const solid::Material& material, const solid::Support& support = {},
                        const EigenOptions& options = {}, Monitor& monitor = silent_monitor());

/// d(omega^2)/d(lambda) = u^T K_lambda u and d(omega^2)/d(mu) = u^T K_mu u of each mode (n_modes x 2), for
/// distinct eigenvalues; in a cluster see modal/reduced_model.hpp.
Eigen::MatrixXd eigenvalue_lame_derivatives(const ModalModel& model, const solid::AssembledSolid& assembled);

/// Peak resident memory of this process so far.
std::size_t peak_memory_bytes();

}  // namespace klang::modal
