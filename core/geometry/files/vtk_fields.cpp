#include "core/geometry/files/vtk_fields.hpp"

#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::mesh {
void add_numbers(vtkFieldData* fields, const std::string& name, const double* values, Eigen::Index n) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name.c_str());
  array->SetNumberOfValues(n);
  for (Eigen::Index i = 0; i < n; ++i) array->SetValue(i, values[i]);
  fields->AddArray(array);
}

void add_integers(vtkFieldData* fields, const std::string& name, const std::vector<int>& values) {
  vtkNew<vtkIntArray> array;
  array->SetName(name.c_str());
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) array->SetValue(static_cast<vtkIdType>(i), values[i]);
  fields->AddArray(array);
}

void add_text(vtkFieldData* fields, const std::string& name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name.c_str());
  array->InsertNextValue(text);
  fields->AddArray(array);
}

void write_grid(const std::filesystem::path& path, vtkUnstructuredGrid* grid, const std::string& what) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->WriteToOutputStringOn();
  if (writer->Write() == 0) throw InputError(path.string(), "the " + what + " could not be encoded");
  write_file(path, writer->GetOutputString());
}

GridFile::GridFile(const std::filesystem::path& path, std::string what, const char* version_field, int version)
    : GridFile(read_file(path), path.string(), std::move(what), version_field, version) {}

GridFile::GridFile(std::string bytes, const std::string& name, std::string what, const char* version_field, int version)
    : place_(name), what_(std::move(what)), file_(std::move(bytes), name, "UnstructuredGrid") {
  const std::vector<int> versions = integers(version_field);
  if (versions.size() != 1) fail(std::string("field ") + version_field + " must hold one integer");
  if (versions[0] != version)
    fail("its version is " + std::to_string(versions[0]) + ", this program reads " + std::to_string(version));
}

void GridFile::fail(const std::string& problem) const { throw InputError(place_, "is no " + what_ + ": " + problem); }

Eigen::VectorXd GridFile::numbers(const std::string& name) const {
  const std::optional<VtkArray> array = file_.find(VtkPlace::kFieldData, name);
  if (!array || array->type != "Float64") fail("field " + name + " is missing");
  return Eigen::Map<const Eigen::VectorXd>(array->reals.data(), static_cast<Eigen::Index>(array->reals.size()));
}

Eigen::VectorXd GridFile::numbers(const std::string& name, Eigen::Index n) const {
  Eigen::VectorXd values = numbers(name);
  if (values.size() != n) fail("field " + name + " must hold " + std::to_string(n) + " numbers");
  return values;
}

double GridFile::number(const std::string& name) const {
  const Eigen::VectorXd values = numbers(name);
  if (values.size() != 1) fail("field " + name + " must hold one number");
  return values[0];
}

std::vector<int> GridFile::integers(const std::string& name) const {
  const std::optional<VtkArray> array = file_.find(VtkPlace::kFieldData, name);
  if (!array || array->type != "Int32") fail("field " + name + " is missing");
  return {array->integers.begin(), array->integers.end()};
}

std::string GridFile::text(const std::string& name) const {
  const std::optional<std::string> text = file_.find_text(name);
  if (!text) fail("field " + name + " is missing");
  return *text;
}

std::vector<double> GridFile::point_numbers(const std::string& name, std::int64_t n_components) const {
  std::optional<VtkArray> array = file_.find(VtkPlace::kPointData, name);
  if (!array || array->type != "Float64" || array->n_components != n_components)
    fail("point array " + name + " is missing");
  return std::move(array->reals);
}

std::vector<int> GridFile::point_integers(const std::string& name) const {
  const std::optional<VtkArray> array = file_.find(VtkPlace::kPointData, name);
  if (!array || array->type != "Int32" || array->n_components != 1) fail("point array " + name + " is missing");
  return {array->integers.begin(), array->integers.end()};
}

}  // namespace klang::mesh
