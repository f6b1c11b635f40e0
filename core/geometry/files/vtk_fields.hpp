#pragma once
#include <vtkFieldData.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/files/vtk_xml.hpp"

namespace klang::mesh {

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
  GridFile(std::string bytes, const std::string& name, std::string what, const char* version_field, int version);
  const VtkXmlFile& file() const { return file_; }
  [[noreturn]] void fail(const std::string& problem) const;  ///< "PATH: is no WHAT: problem"

  Eigen::VectorXd numbers(const std::string& name) const;
  /// As numbers, of this many entries.
  Eigen::VectorXd numbers(const std::string& name, Eigen::Index n) const;
  double number(const std::string& name) const;
  std::vector<int> integers(const std::string& name) const;
  std::string text(const std::string& name) const;
  /// Of the points: n_components numbers each, one after the other.
  std::vector<double> point_numbers(const std::string& name, std::int64_t n_components = 1) const;
  std::vector<int> point_integers(const std::string& name) const;

 private:
  std::string place_, what_;
  VtkXmlFile file_;
};

}  // namespace klang::mesh
