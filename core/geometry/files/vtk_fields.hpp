#pragma once
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

class vtkXMLReader;

namespace klang::mesh {

/// VTK allocates what the header promises: refuses promises that no compression of this file could keep (InputError).
void check_promises(std::string_view bytes, const std::string& name);

/// Reads a VTK XML file's bytes without a word on the terminal. @return what is wrong, empty when all is well
std::string update_reader(vtkXMLReader* reader, const std::string& bytes, const std::string& name);

/// Named arrays of a model file. Field data and point data take them alike; reading gives back every bit.
void add_numbers(vtkFieldData* fields, const std::string& name, const double* values, Eigen::Index n);
void add_integers(vtkFieldData* fields, const std::string& name, const std::vector<int>& values);
void add_text(vtkFieldData* fields, const std::string& name, const std::string& text);

/// Writes the grid as a .vtu with raw appended data, whole or not at all. what: "modal model", for the message.
void write_grid(const std::filesystem::path& path, vtkUnstructuredGrid* grid, const std::string& what);

/// A grid read from a model file, with the file's name in every complaint (InputError).
class GridFile {
 public:
  /// version_field holds one integer that must equal version.
  GridFile(const std::filesystem::path& path, std::string what, const char* version_field, int version);
  vtkUnstructuredGrid* grid() const { return grid_; }
  [[noreturn]] void fail(const std::string& problem) const;  ///< "PATH: is no WHAT: problem"

  Eigen::VectorXd numbers(const std::string& name) const;
  /// As numbers, of this many entries.
  Eigen::VectorXd numbers(const std::string& name, Eigen::Index n) const;
  double number(const std::string& name) const;
  std::vector<int> integers(const std::string& name) const;
  std::string text(const std::string& name) const;

 private:
  std::string place_, what_;
  vtkSmartPointer<vtkUnstructuredGrid> grid_;
};

}  // namespace klang::mesh
