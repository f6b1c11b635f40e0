#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkOpenFOAMReader.h>
#include <vtkPointData.h>
#include <vtkProbeFilter.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/child.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/liquid/distance_grid.hpp"
#include "core/sound/liquid_scene/foam_text.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;

/// What VTK makes of a case's text: cells know their points and faces, fields are held in cells and points.
constexpr double kMostCellsPerOwn = 100, kCellsAlways = 1e5;  // of the box around a case, where their size is not given
constexpr std::size_t kMemoryPerByte = 64, kMemoryAlways = std::size_t{1} << 30;

/// VTK's complaints go to the terminal; ours say what matters.
class Quiet {
 public:
  Quiet() : before_(vtkObject::GetGlobalWarningDisplay()) { vtkObject::GlobalWarningDisplayOff(); }
  ~Quiet() { vtkObject::SetGlobalWarningDisplay(before_); }

 private:
  int before_;
};

class OpenFoamFrames : public ForeignFrames {
 public:
  OpenFoamFrames(const ForeignOptions& options, Monitor& monitor) : options_(options) {
    const std::filesystem::path given(options.frames);
    case_ = std::filesystem::is_directory(given) ? given : given.parent_path();
    const std::filesystem::path control = case_ / "system" / "controlDict";
    read_file(control, std::size_t{64} << 20);  // a case has one
    files_ = {control};
    try_in_child(check_foam_case(case_), monitor);
    open_case();
    frame_step_s_ = even_step_s(time_s_, case_.string());
    monitor.throw_if_stopped();
    vtkUnstructuredGrid* const mesh = grid_at(0);
    double b[6];
    mesh->GetBounds(b);
    double longest = 0.0;  // points are read in single precision
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, b[2 * axis + 1] - b[2 * axis]);
    const double digit = std::pow(10.0, std::floor(std::log10(std::max(longest, 1e-300))) - 5.0);
    for (double& bound : b) bound = std::round(bound / digit) * digit;
    const Vector3d low = ours(Vector3d(b[0], b[2], b[4])), high = ours(Vector3d(b[1], b[3], b[5]));
    const Vector3d from = low.cwiseMin(high), size = low.cwiseMax(high) - from;
    const double volume = size.prod() / static_cast<double>(std::max<vtkIdType>(mesh->GetNumberOfCells(), 1));
    const double cell = options.cell_m.value_or(even_cell(size, std::cbrt(volume)));
    if (size.minCoeff() < 1.5 * cell)
      throw InputError(case_.string(), "is thinner than 2 cells: sound needs three dimensions",
                       to_text(size.minCoeff()) + " m of cells of " + to_text(cell) + " m");
    const double n_cells = size.prod() / (cell * cell * cell), n_own = static_cast<double>(mesh->GetNumberOfCells());
    if (!options.cell_m && n_cells > kMostCellsPerOwn * n_own + kCellsAlways)
      throw InputError(case_.string(), "fills a small part of the box around it: a stray point?",
                       to_text(std::round(n_cells)) + " cells for its " + to_text(n_own),
                       "or a size of cells (--cell-m)");
    set_box(from, from + size, cell);
    const double off = (shape_.size_m() - size).cwiseAbs().maxCoeff();
    if (off > 0.01 * cell)
      warnings_.push_back("the box is no whole number of cells of " + to_text(cell) + " m: walls are off by up to " +
                          to_text(off) + " m");
  }

  std::size_t n_frames() const override { return time_s_.size(); }

  ForeignFrame read(std::size_t frame) override {
    const Quiet quiet;
    vtkUnstructuredGrid* const mesh = grid_at(frame);
    vtkDataArray* const share = share_of(mesh);
    if (share == nullptr)
      throw InputError(case_.string(), field_word() + " cannot be read at " + to_text(time_s_[frame]) + " s", "",
                       "finite numbers");
    vtkNew<vtkImageData> image;
    image->SetDimensions(shape_.nx, shape_.ny, shape_.nz);
    const double h = shape_.cell_m / options_.unit_m;
    image->SetSpacing(h, h, h);
    // Our cells in the case's axes; turned back below.
    const Vector3d first = theirs(low_m_ + 0.5 * shape_.cell_m * Vector3d::Ones());
    if (options_.y_up) {
      image->SetDimensions(shape_.nx, shape_.nz, shape_.ny);
      image->SetOrigin(first.x(), first.y(), first.z() - h * (shape_.ny - 1));
    } else {
      image->SetOrigin(first.x(), first.y(), first.z());
    }
    vtkNew<vtkProbeFilter> probe;
    probe->SetInputData(image);
    probe->SetSourceData(mesh);
    probe->Update();
    vtkPointData* const data = probe->GetOutput()->GetPointData();
    vtkDataArray* const found = data->GetArray(share->GetName());
    vtkDataArray* const valid = data->GetArray("vtkValidPointMask");
    vtkDataArray* const velocity = data->GetArray("U");
    if (found == nullptr || valid == nullptr)
      throw InputError(case_.string(), "cannot be sampled at " + to_text(time_s_[frame]) + " s");
    return made_of(*found, *valid, velocity);
  }

 private:
  /// @param size of the case's text
  void try_in_child(std::size_t size, Monitor& monitor) {
    // All of it: VTK's reader takes memory as files claim it and crashes on some that are broken.
    const ChildResult child = run_in_child(
        [&] {
          open_case();
          for (std::size_t k = 0; k < time_s_.size(); ++k) grid_at(k);
          return std::string();
        },
        monitor, kMemoryAlways + kMemoryPerByte * size);
    if (!child.done && (child.signal != 0 || child.bytes.empty()))
      throw InputError(case_.string(), "is damaged: VTK's reader ends at it");
    if (!child.done) throw InputError(child.bytes);
  }

  void open_case() {
    const Quiet quiet;
    reader_->SetFileName((case_ / "system" / "controlDict").c_str());
    reader_->SkipZeroTimeOff();
    reader_->UpdateInformation();
    reader_->EnableAllCellArrays();
    reader_->DisableAllPatchArrays();
    reader_->EnableAllCellArrays();
    reader_->SetPatchArrayStatus("internalMesh", 1);
    vtkDoubleArray* const times = reader_->GetTimeValues();
    std::vector<double> without_field;
    for (vtkIdType k = 0; times != nullptr && k < times->GetNumberOfTuples(); ++k)
      (has_field(times->GetValue(k)) ? time_s_ : without_field).push_back(times->GetValue(k));
    if (time_s_.empty())
      throw InputError(case_.string(), "is no OpenFOAM case with times that hold " + field_word(), "",
                       "a folder with system/controlDict, constant/polyMesh and folders of times");
    if (!without_field.empty())
      warnings_.push_back(std::to_string(without_field.size()) + " time(s) without " + field_word() +
                          " are left out, the first at " + to_text(without_field.front()) + " s");
  }

  Vector3d ours(const Vector3d& x) const {
    return options_.unit_m * (options_.y_up ? Vector3d(x.x(), -x.z(), x.y()) : x);
  }
  Vector3d theirs(const Vector3d& x) const {
    return (options_.y_up ? Vector3d(x.x(), x.z(), -x.y()) : x) / options_.unit_m;
  }
  std::string field_word() const { return options_.field.empty() ? "alpha.*" : options_.field; }

  /// Whether a time's folder has the share of liquid: the start of some cases has not, and other folders look like times.
  bool has_field(double time_s) const {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(case_, error)) {
      char* end = nullptr;
      const std::string name = entry.path().filename().string();
      const double value = std::strtod(name.c_str(), &end);
      if (end == name.c_str() || *end != '\0' || !(std::abs(value - time_s) <= 1e-9 * std::max(1.0, std::abs(time_s))))
        continue;
      for (const auto& file : std::filesystem::directory_iterator(entry.path(), error)) {
        std::string field = file.path().filename().string();
        if (field.ends_with(".gz")) field.resize(field.size() - 3);
        if (options_.field.empty() ? field.starts_with("alpha.") : field == options_.field) return true;
      }
    }
    return false;
  }

  /// Cubes near an edge that fill the box.
  static double even_cell(const Vector3d& size, double edge) {
    double best = edge, least = HUGE_VAL;
    const double shortest = size.minCoeff();
    const int about = std::max(2, static_cast<int>(std::lround(shortest / edge)));
    for (int n = std::max(2, about - 2); n <= about + 2; ++n) {
      const double cell = shortest / n;
      double off = 0.02 * std::abs(n - about);
      for (int axis = 0; axis < 3; ++axis) off += std::abs(size[axis] / cell - std::round(size[axis] / cell));
      if (off < least) {
        least = off;
        best = cell;
      }
    }
    return best;
  }

  vtkUnstructuredGrid* grid_at(std::size_t frame) {
    const Quiet quiet;
    reader_->SetTimeValue(time_s_[frame]);
    reader_->Modified();
    reader_->Update();
    vtkMultiBlockDataSet* const output = reader_->GetOutput();
    vtkSmartPointer<vtkCompositeDataIterator> it;
    it.TakeReference(output->NewIterator());
    for (it->InitTraversal(); !it->IsDoneWithTraversal(); it->GoToNextItem())
      if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(it->GetCurrentDataObject()))
        if (grid->GetNumberOfCells() > 0) return grid;
    throw InputError(case_.string(), "has no cells at " + to_text(time_s_[frame]) + " s", "", "constant/polyMesh");
  }

  vtkDataArray* share_of(vtkUnstructuredGrid* mesh) const {
    vtkPointData* const data = mesh->GetPointData();
    for (int a = 0; a < data->GetNumberOfArrays(); ++a) {
      const char* const name = data->GetArrayName(a);
      if (name == nullptr) continue;
      const std::string word(name);
      if (options_.field.empty() ? word.starts_with("alpha.") : word == options_.field) return data->GetArray(a);
    }
    return nullptr;
  }

  ForeignFrame made_of(vtkDataArray& share, vtkDataArray& valid, vtkDataArray* velocity) {
    const double h = shape_.cell_m;
    ForeignFrame result;
    result.phi_m = liquid::Field(shape_.nx, shape_.ny, shape_.nz);
    liquid::Field open(shape_.nx, shape_.ny, shape_.nz);
    bool any_closed = false;
    const auto at = [&](int i, int j, int k) {
      return options_.y_up
                 ? static_cast<vtkIdType>(i) +
                       static_cast<vtkIdType>(shape_.nx) * (k + static_cast<vtkIdType>(shape_.nz) * (shape_.ny - 1 - j))
                 : static_cast<vtkIdType>(shape_.index(i, j, k));
    };
    for (int k = 0; k < shape_.nz; ++k)
      for (int j = 0; j < shape_.ny; ++j)
        for (int i = 0; i < shape_.nx; ++i) {
          const vtkIdType p = at(i, j, k);
          const bool inside = valid.GetComponent(p, 0) > 0.5;
          const double value = share.GetComponent(p, 0);
          if (inside && !(value > -0.5 && value < 1.5))
            throw InputError(case_.string(), "the share of liquid is no share", to_text(value), "0 to 1");
          any_closed = any_closed || !inside;
          open(i, j, k) = inside ? 0.5 * h : -0.5 * h;
          result.phi_m(i, j, k) = inside ? 2.0 * h * (0.5 - value) : HUGE_VAL;
        }
    if (any_closed) {
      continue_into_closed(result.phi_m);
      liquid::distance_from_zero_set(shape_, open);
      result.solid_m = std::move(open);
    }
    liquid::distance_from_zero_set(shape_, result.phi_m);
    if (velocity != nullptr && velocity->GetNumberOfComponents() == 3) {
      result.u.emplace(shape_);
      const auto centre = [&](int axis, int i, int j, int k) {
        const vtkIdType p =
            at(std::clamp(i, 0, shape_.nx - 1), std::clamp(j, 0, shape_.ny - 1), std::clamp(k, 0, shape_.nz - 1));
        const Vector3d u(velocity->GetComponent(p, 0), velocity->GetComponent(p, 1), velocity->GetComponent(p, 2));
        return ours(u)[axis];
      };
      for (int axis = 0; axis < 3; ++axis) {
        liquid::Field& u = (*result.u)[axis];
        for (int k = 0; k < u.nz(); ++k)
          for (int j = 0; j < u.ny(); ++j)
            for (int i = 0; i < u.nx(); ++i)
              u(i, j, k) = 0.5 * (centre(axis, i, j, k) + centre(axis, i - (axis == 0 ? 1 : 0), j - (axis == 1 ? 1 : 0),
                                                                 k - (axis == 2 ? 1 : 0)));
      }
    } else if (!said_) {
      said_ = true;
      warnings_.push_back(
          "the case has no field U: bubbles come from [[bubble]] alone, and the liquid does not carry them");
    }
    return result;
  }

  /// Visits the up to 6 neighbours of a cell.
  template <class Visit>
  void each_neighbour(const Eigen::Vector3i& cell, Visit&& visit) const {
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Eigen::Vector3i next = cell;
        next[axis] += step;
        if (next[axis] >= 0 && next[axis] < Eigen::Vector3i(shape_.nx, shape_.ny, shape_.nz)[axis]) visit(next);
      }
  }

  /// Cells outside the case's mesh go on as their neighbours do, layer after layer, so that a wall is no surface.
  void continue_into_closed(liquid::Field& phi) const {
    const auto value = [&](const Eigen::Vector3i& c) -> double& { return phi(c.x(), c.y(), c.z()); };
    std::vector<Eigen::Vector3i> known, front;
    for (int k = 0; k < shape_.nz; ++k)
      for (int j = 0; j < shape_.ny; ++j)
        for (int i = 0; i < shape_.nx; ++i)
          if (std::isfinite(phi(i, j, k))) known.emplace_back(i, j, k);
    liquid::Field listed(shape_.nx, shape_.ny, shape_.nz);
    const auto next_layer = [&](const std::vector<Eigen::Vector3i>& of) {
      front.clear();
      for (const Eigen::Vector3i& cell : of)
        each_neighbour(cell, [&](const Eigen::Vector3i& c) {
          double& mark = listed(c.x(), c.y(), c.z());
          if (mark != 0.0 || std::isfinite(value(c))) return;
          mark = 1.0;
          front.push_back(c);
        });
    };
    std::vector<double> values;
    for (next_layer(known); !front.empty(); next_layer(known)) {
      values.clear();
      for (const Eigen::Vector3i& cell : front) {
        double sum = 0.0;
        int count = 0;
        each_neighbour(cell, [&](const Eigen::Vector3i& c) {
          if (!std::isfinite(value(c))) return;
          sum += value(c);
          ++count;
        });
        values.push_back(sum / count);
      }
      for (std::size_t i = 0; i < front.size(); ++i) value(front[i]) = values[i];
      known = front;
    }
    for (double& left : phi.data())
      if (!std::isfinite(left)) left = shape_.cell_m;  // nothing inside at all
  }

  const ForeignOptions options_;
  std::filesystem::path case_;
  vtkNew<vtkOpenFOAMReader> reader_;
  std::vector<double> time_s_;
  bool said_ = false;
};

}  // namespace

std::unique_ptr<ForeignFrames> openfoam_frames(const ForeignOptions& options, Monitor& monitor) {
  return std::make_unique<OpenFoamFrames>(options, monitor);
}

}  // namespace klang::liquid_scene
