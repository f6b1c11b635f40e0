#include "core/geometry/files/vtk_fields.hpp"

#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/files/byte_cursor.hpp"

namespace klang::mesh {
namespace {

// Takes what VTK's reader has to say, which it would print otherwise.
class ErrorCatcher : public vtkCommand {
 public:
  static ErrorCatcher* New() { return new ErrorCatcher; }  // NOLINT: VTK counts references
  void Execute(vtkObject*, unsigned long event, void*) override { failed = failed || event == vtkCommand::ErrorEvent; }
  bool failed = false;
};

}  // namespace

std::string update_reader(vtkXMLReader* reader, const std::string& bytes, const std::string& name) {
  if (bytes.substr(0, 4096).find("<VTKFile") == std::string::npos) return "it is no VTK XML file";
  if (bytes.find("</VTKFile>") == std::string::npos) return "it is cut off";
  check_promises(bytes, name);
  vtkNew<ErrorCatcher> catcher;
  reader->AddObserver(vtkCommand::ErrorEvent, catcher);
  reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, catcher);
  reader->SetReaderErrorObserver(catcher);
  reader->SetParserErrorObserver(catcher);
  reader->ReadFromInputStringOn();
  reader->SetInputString(bytes);
  try {
    reader->Update();
  } catch (const std::exception& error) {
    return std::string("the VTK reader failed: ") + error.what();
  }
  return catcher->failed || reader->GetOutputAsDataSet() == nullptr ? "VTK cannot read it" : "";
}

void check_promises(std::string_view bytes, const std::string& name) {
  for (const std::string_view attribute : {std::string_view("NumberOfPoints=\""), std::string_view("NumberOfCells=\"")})
    for (std::size_t at = bytes.find(attribute); at != std::string_view::npos; at = bytes.find(attribute, at + 1)) {
      const std::size_t begin = at + attribute.size(), end = bytes.find('"', begin);
      long long n = 0;
      if (end == std::string_view::npos || !parse_integer(bytes.substr(begin, end - begin), n) || n < 0 ||
          n > 2147483647 || static_cast<double>(n) > 100.0 * static_cast<double>(bytes.size()))
        throw InputError(
            name, std::string(attribute.substr(0, attribute.size() - 2)) + " does not fit the length of the file",
            std::string(bytes.substr(begin, std::min<std::size_t>(24, bytes.size() - begin))
                            .substr(0, bytes.substr(begin).find('"'))));
    }
}

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
    : place_(path.string()), what_(std::move(what)) {
  const std::string bytes = read_file(path);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  if (const std::string problem = update_reader(reader, bytes, place_); !problem.empty()) fail(problem);
  grid_ = reader->GetOutput();
  auto* array = vtkIntArray::SafeDownCast(grid_->GetFieldData()->GetAbstractArray(version_field));
  if (array == nullptr || array->GetNumberOfValues() != 1) fail(std::string("field ") + version_field + " is missing");
  if (array->GetValue(0) != version) {
    fail("its version is " + std::to_string(array->GetValue(0)) + ", this program reads " + std::to_string(version));
  }
}

void GridFile::fail(const std::string& problem) const { throw InputError(place_, "is no " + what_ + ": " + problem); }

Eigen::VectorXd GridFile::numbers(const std::string& name) const {
  auto* array = vtkDoubleArray::SafeDownCast(grid_->GetFieldData()->GetAbstractArray(name.c_str()));
  if (array == nullptr) fail("field " + name + " is missing");
  return Eigen::Map<const Eigen::VectorXd>(array->GetPointer(0), array->GetNumberOfValues());
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
  auto* array = vtkIntArray::SafeDownCast(grid_->GetFieldData()->GetAbstractArray(name.c_str()));
  if (array == nullptr) fail("field " + name + " is missing");
  return {array->GetPointer(0), array->GetPointer(0) + array->GetNumberOfValues()};
}

std::string GridFile::text(const std::string& name) const {
  auto* array = vtkStringArray::SafeDownCast(grid_->GetFieldData()->GetAbstractArray(name.c_str()));
  if (array == nullptr || array->GetNumberOfValues() < 1) fail("field " + name + " is missing");
  return array->GetValue(0);
}

}  // namespace klang::mesh
