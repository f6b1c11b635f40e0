#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/modal/damping/damping_reader.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "fit/run/fit_document.hpp"
#include "fit/specimen/specimen.hpp"

/// What a fit found, as a body that can be struck, changed and cut anew.
namespace klang::fit {

/// fit.json. @throws InputError: no such file, another kind of result, a fit that did not converge
FitDocument read_fit_document(const std::filesystem::path& path);

/// @param name  of a specimen; empty: the only one. @throws InputError listing the names
const SpecimenRecord& specimen_of(const FitDocument& fit, const std::string& name, const std::filesystem::path& path);

/// Kind and fitted dimensions; the profile of a body of revolution is the file that the fit read.
/// @throws InputError for a body that was given as a mesh; a profile that is gone or is not what it was
mesh::ShapeSpec fitted_shape(const FitDocument& fit, const SpecimenRecord& specimen, const std::filesystem::path& path);

/// The fitted elasticity with the density of that specimen: its mass over its volume.
solid::Material stock_material(const FitDocument& fit, const SpecimenRecord& specimen, const mesh::ShapeSpec& shape,
                               const std::filesystem::path& path);

/// The best damping law without what radiation and mounts added to it; empty where no decay was measured.
std::optional<damping::LawValue> fitted_law(const FitDocument& fit);

/// What is to be different from what was struck.
struct BodyChange {
  std::map<std::string, double> dims;       ///< of the shape, by name [m]
  std::optional<solid::Material> material;  ///< its damping stays the fit's
  bool any() const { return !dims.empty() || material.has_value(); }
};

struct FittedBody {
  modal::ModalModel model;
  std::optional<Eigen::VectorXd> decay_per_s;  ///< one per mode; empty: the fit has no damping
};

/// Of every mode of a thing whose damping nobody measured, by damping::kAssumedLossFactor.
Eigen::VectorXd assumed_decay_per_s(const modal::ModalModel& model);

/// The specimen's modes as modes-NAME.vtu beside the fit has them, each with the decay that the fit predicts for it (mounts and
/// radiation included); of a changed body modes solved anew, up to the same frequency and as many, damped by the material's law alone.
/// @throws InputError: no such specimen, no modes-NAME.vtu, a dimension that the shape does not have
FittedBody fitted_body(const FitDocument& fit, const std::filesystem::path& path, const std::string& specimen,
                       const BodyChange& change, Monitor& monitor = silent_monitor());

/// The fit.json beside a modes-NAME.vtu that `klang fit` wrote, and the specimen's name there; empty where there is none.
struct FitBeside {
  std::filesystem::path path;
  std::string specimen;
};
std::optional<FitBeside> fit_beside(const std::filesystem::path& modes_file);

}  // namespace klang::fit
