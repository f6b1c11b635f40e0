#include "fit/elastic/elastic_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/box_modes.hpp"
#include "core/physics/modal/revolution_modes.hpp"
#include "core/physics/solid/rigid_modes.hpp"

namespace klang::fit::detail {
namespace {

constexpr double kLeftOfEstimate = 0.2;  // of a mesh error's estimate

Eigen::MatrixXd product(const solid::SparseMatrix& lower, const Eigen::MatrixXd& basis) {
  const Eigen::MatrixXd image = lower.selfadjointView<Eigen::Lower>() * basis;
  const Eigen::MatrixXd full = basis.transpose() * image;
  return 0.5 * (full + full.transpose());
}

/// Frequencies without the mesh's error. Conforming elements are too stiff; the estimate of how much is right to a sixth
/// (modal/mesh_error.hpp).
Eigen::VectorXd corrected_hz(const modal::EigenResult& result) {
  const Eigen::VectorXd frequency_hz = result.model.frequency_hz();
  if (!result.mesh_relative_error) return frequency_hz;
  return frequency_hz.array() * (1.0 - result.mesh_relative_error->array());
}

/// Takes the mesh's error out of the frequencies and sorts the modes by what they are then.
/// @return the error of each
Eigen::VectorXd correct(modal::EigenResult& result) {
  const Eigen::VectorXd frequency_hz = corrected_hz(result);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(frequency_hz.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return frequency_hz[a] < frequency_hz[b]; });
  result.model.angular_frequency_rad_s = 2.0 * kPi * frequency_hz(order);
  result.model.shapes = result.model.shapes(Eigen::all, order).eval();
  result.relative_residual = result.relative_residual(order).eval();
  if (!result.mesh_relative_error) return Eigen::VectorXd::Zero(frequency_hz.size());
  return (*result.mesh_relative_error)(order);
}

class TetBlocks : public ElasticBlocks {
 public:
  TetBlocks(const Specimen& specimen, const SpecimenBody& body, Monitor& monitor)
      : name_(specimen.name),
        support_(specimen.support),
        mesh_(body.mesh),
        volume_m3_(body.volume_m3),
        assembled_(solid::assemble(body.mesh, specimen.support)),
        monitor_(monitor) {}
  std::size_t n_blocks() const override { return 1; }
  int multiplicity(std::size_t) const override { return 1; }
  double volume_m3() const override { return volume_m3_; }

  BlockModes lowest(const solid::Material& material, const ReducedSpectrumOptions& options, bool prove) override {
    // Free modes are fewer than the degrees of freedom; tiny meshes must not be asked for more.
    const int most = std::max(
        1, std::min(std::max(options.max_count, options.min_count), static_cast<int>(assembled_.n_dofs()) / 3 - 6));
    const int least = std::min(options.min_count, most);
    int count = options.count > 0 ? std::min(options.count, most) : std::min(std::max(24, least), most);
    BlockModes modes;
    modes.result = solve(material, count, prove, true);
    // Whether the band is filled is a question to the corrected frequencies: those of the mesh lie higher.
    const auto highest_hz = [&] { return corrected_hz(modes.result).maxCoeff(); };
    if (options.count == 0 && count < most && highest_hz() < options.band.high_hz) {
      // Mode counts grow like f (plates) to f^3 (solids); between them f^1.5 is enough in most cases.
      const double ratio = std::min(options.band.high_hz / highest_hz(), 10.0);
      count = std::min(most, static_cast<int>(std::ceil(1.15 * count * std::pow(ratio, 1.5))) + 4);
      modes.result = solve(material, count, prove, true);
    }
    if (options.count == 0) {  // those beyond the band are of no use
      const auto useful = (corrected_hz(modes.result).array() <= 1.02 * options.band.high_hz).count() + 2;
      count = std::max({std::min<int>(count, static_cast<int>(useful)), least, 1});
    }
    modal::ModalModel& model = modes.result.model;
    const Eigen::VectorXd error = correct(modes.result);
    modes.vectors = {free_rows(model.shapes)};
    modes.correction = {error};
    modes.relative_error = kLeftOfEstimate * error.head(count);
    model.angular_frequency_rad_s.conservativeResize(count);
    model.shapes.conservativeResize(Eigen::NoChange, count);
    modes.result.relative_residual.conservativeResize(count);
    return modes;
  }

  std::vector<Eigen::MatrixXd> vectors(const solid::Material& material, const std::vector<int>& counts) override {
    return {free_rows(solve(material, counts.front(), false, false).model.shapes)};
  }
  Eigen::MatrixXd projected_mass(std::size_t, const Eigen::MatrixXd& basis) const override {
    return product(assembled_.mass_unit_density, basis);
  }
  Eigen::MatrixXd rigid_motions(std::size_t) const override { return solid::rigid_modes(mesh_, assembled_); }
  BlockMatrices projected(std::size_t, const Eigen::MatrixXd& basis) const override {
    return {product(assembled_.stiffness_lambda, basis), product(assembled_.stiffness_mu, basis),
            product(assembled_.mass_unit_density, basis)};
  }

 private:
  modal::EigenResult solve(const solid::Material& material, int count, bool prove, bool estimate) {
    modal::EigenOptions eigen;
    eigen.count = count;
    eigen.band.low_hz = 0.0;
    eigen.prove_none_missing = prove;
    eigen.estimate_mesh_error = estimate;
    auto result = modal::solve_modes(mesh_, assembled_, material, support_, eigen, monitor_);
    if (!result.usable()) throw NumericalError("specimen " + name_ + ": " + result.message);
    return result;
  }
  Eigen::MatrixXd free_rows(const Eigen::MatrixXd& shapes) const {
    Eigen::MatrixXd rows(assembled_.n_dofs(), shapes.cols());
    for (std::size_t i = 0; i < assembled_.free_nodes.size(); ++i) {
      rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = shapes.middleRows<3>(3 * assembled_.free_nodes[i]);
    }
    return rows;
  }

  std::string name_;
  solid::Support support_;
  const mesh::TetMesh& mesh_;
  double volume_m3_;
  solid::AssembledSolid assembled_;
  Monitor& monitor_;
};

/// Modes of a body whose problem falls into systems (harmonics of a section, parities of a box).
struct SystemModes {
  std::vector<modal::HarmonicModes>
      all;  ///< a few more than asked for: they come into the band when material or dimensions change
  std::vector<modal::HarmonicModes> shown;  ///< those whose shapes are sampled for what is shown and written
};

template <class Body, class Count>
SystemModes system_modes(Body& body, const solid::Material& material, const ReducedSpectrumOptions& options,
                         const Count& count) {
  const int least = std::max({1, options.count, options.min_count});
  double highest_hz = options.band.high_hz;
  SystemModes modes;
  for (int round = 0; round < 40; ++round) {
    modes.all = body.modes_up_to(material, 1.15 * highest_hz);
    if (count(modes.all) >= least) break;
    highest_hz *= 1.3;
  }
  modes.shown = modes.all;
  for (auto& system : modes.shown) {
    const auto n = (system.angular_frequency_sq.array() <= std::pow(2.0 * kPi * 1.02 * highest_hz, 2)).count();
    system.angular_frequency_sq.conservativeResize(n);
  }
  if (count(modes.shown) < least) modes.shown = modes.all;
  return modes;
}

/// As many as with tetrahedra.
Eigen::Index most_modes(const ReducedSpectrumOptions& options) {
  return options.count > 0 ? options.count : std::max(4 * options.max_count, options.min_count);
}

/// All systems' vectors and the first n of the sampled modes; neither errors nor rigid modes.
BlockModes block_modes(const std::vector<modal::HarmonicModes>& all, modal::SampledModes sampled, Eigen::Index n) {
  BlockModes modes;
  for (const auto& system : all) modes.vectors.push_back(system.vectors);
  modes.result.status = modal::EigenStatus::kConverged;
  modes.result.none_missing = true;
  modes.result.model = std::move(sampled.model);
  modes.result.model.angular_frequency_rad_s.conservativeResize(n);
  modes.result.model.shapes.conservativeResize(Eigen::NoChange, n);
  modes.result.relative_residual = sampled.relative_residual.head(n);
  return modes;
}

class SectionBlocks : public ElasticBlocks {
 public:
  SectionBlocks(const Specimen& specimen, const SpecimenBody& body, std::size_t like_blocks)
      : name_(specimen.name),
        shape_(*specimen.shape),
        divisions_(*body.section),
        mesh_(body.mesh),
        body_(mesh::mesh_section(shape_, divisions_)) {
    body_.extend(like_blocks);
  }
  std::size_t n_blocks() const override { return body_.n_systems(); }
  int multiplicity(std::size_t block) const override { return body_.system(block).multiplicity; }
  double volume_m3() const override { return body_.volume_m3(); }

  BlockModes lowest(const solid::Material& material, const ReducedSpectrumOptions& options, bool) override {
    const SystemModes found =
        system_modes(body_, material, options, [this](const auto& modes) { return count(modes); });
    modal::SampledModes sampled = modal::sample_modes(body_, found.shown, mesh_, material);
    const Eigen::Index n = std::min(sampled.model.n_modes(), most_modes(options));
    const Eigen::VectorXd error = modal::section_mesh_error(shape_, divisions_, material, found.all, sampled, n);
    BlockModes modes = block_modes(found.all, std::move(sampled), n);
    modes.relative_error = error;
    modes.result.n_rigid_modes = 6;
    return modes;
  }

  std::vector<Eigen::MatrixXd> vectors(const solid::Material& material, const std::vector<int>& counts) override {
    std::vector<Eigen::MatrixXd> vectors;
    for (auto& harmonic : body_.lowest(material, counts)) vectors.push_back(std::move(harmonic.vectors));
    return vectors;
  }
  Eigen::MatrixXd projected_mass(std::size_t block, const Eigen::MatrixXd& basis) const override {
    return product(body_.system(block).mass_unit_density, basis);
  }
  BlockMatrices projected(std::size_t block, const Eigen::MatrixXd& basis) const override {
    const auto& system = body_.system(block);
    return {product(system.stiffness_lambda, basis), product(system.stiffness_mu, basis),
            product(system.mass_unit_density, basis)};
  }

 private:
  int count(const std::vector<modal::HarmonicModes>& modes) const {
    int n = 0;
    for (std::size_t b = 0; b < modes.size(); ++b)
      n += body_.system(b).multiplicity * static_cast<int>(modes[b].angular_frequency_sq.size());
    return n;
  }

  std::string name_;
  mesh::ShapeSpec shape_;
  mesh::SectionDivisions divisions_;
  const mesh::TetMesh& mesh_;
  modal::AxisymmetricBody body_;
};

class BoxBlocks : public ElasticBlocks {
 public:
  BoxBlocks(const Specimen& specimen, const SpecimenBody& body)
      : support_(specimen.support),
        half_m_(modal::box_half_lengths_m(*specimen.shape)),
        held_(*modal::held_faces(specimen.support, half_m_)),
        degrees_(*body.polynomials),
        mesh_(body.mesh),
        body_(half_m_, degrees_, held_) {}
  std::size_t n_blocks() const override { return body_.n_systems(); }
  int multiplicity(std::size_t) const override { return 1; }
  double volume_m3() const override { return body_.volume_m3(); }

  BlockModes lowest(const solid::Material& material, const ReducedSpectrumOptions& options, bool) override {
    const SystemModes found = system_modes(body_, material, options, count);
    std::vector<int> counts;
    for (const auto& system : found.all) counts.push_back(static_cast<int>(system.angular_frequency_sq.size()));
    modal::SampledModes sampled = modal::sample_box_modes(body_, found.shown, mesh_, material, support_);
    const Eigen::Index n = std::min(sampled.model.n_modes(), most_modes(options));
    const modal::BoxBody lower(half_m_, modal::box_degrees_raised(half_m_, degrees_, -1), held_);
    const auto bound = modal::box_error_bound(lower.lowest(material, counts), found.all, degrees_, held_);
    Eigen::VectorXd error(n);
    for (Eigen::Index k = 0; k < n; ++k)
      error[k] = bound[static_cast<std::size_t>(sampled.system[static_cast<std::size_t>(k)])]
                      [sampled.index[static_cast<std::size_t>(k)]];
    BlockModes modes = block_modes(found.all, std::move(sampled), n);
    modes.relative_error = std::move(error);
    for (std::size_t s = 0; s < body_.n_systems(); ++s) modes.result.n_rigid_modes += body_.n_rigid(s);
    return modes;
  }

  std::vector<Eigen::MatrixXd> vectors(const solid::Material& material, const std::vector<int>& counts) override {
    std::vector<Eigen::MatrixXd> vectors;
    for (auto& system : body_.lowest(material, counts)) vectors.push_back(std::move(system.vectors));
    return vectors;
  }
  Eigen::MatrixXd projected_mass(std::size_t, const Eigen::MatrixXd& basis) const override {
    return 0.125 * body_.volume_m3() * basis.transpose() * basis;
  }
  BlockMatrices projected(std::size_t block, const Eigen::MatrixXd& basis) const override {
    const auto stiffness = body_.projected(block, basis);
    return {stiffness.lambda, stiffness.mu, projected_mass(block, basis)};
  }

 private:
  static int count(const std::vector<modal::HarmonicModes>& modes) {
    return std::accumulate(modes.begin(), modes.end(), 0, [](int n, const modal::HarmonicModes& system) {
      return n + static_cast<int>(system.angular_frequency_sq.size());
    });
  }

  solid::Support support_;
  Eigen::Vector3d half_m_;
  modal::HeldFaces held_;
  modal::BoxDegrees degrees_;
  const mesh::TetMesh& mesh_;
  modal::BoxBody body_;
};

}  // namespace

std::unique_ptr<ElasticBlocks> elastic_blocks(const Specimen& specimen, const SpecimenBody& body,
                                              std::size_t like_blocks, Monitor& monitor) {
  if (body.section) return std::make_unique<SectionBlocks>(specimen, body, like_blocks);
  if (body.polynomials) return std::make_unique<BoxBlocks>(specimen, body);
  return std::make_unique<TetBlocks>(specimen, body, monitor);
}

}  // namespace klang::fit::detail
