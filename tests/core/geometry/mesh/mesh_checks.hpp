#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::test {

/// Faces belong to one or two elements, with the same mid-nodes seen from both; the boundary is closed (each
/// directed edge once, and once the other way); every node is used; no element is folded.
inline void expect_conforming(const TetMesh& mesh) {
  std::map<std::array<int, 3>, std::vector<std::array<int, 3>>> mids_of_face;
  std::vector<char> used(mesh.n_nodes(), 0);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) used[mesh.elements(e, c)] = 1;
    for (const auto& face : kTetFaces) {
      std::array<int, 3> corners, mids{-1, -1, -1};
      for (int c = 0; c < 3; ++c) {
        corners[c] = mesh.elements(e, face[c]);
        if (mesh.order() == 2) mids[c] = mesh.elements(e, tet_mid_column(face[c], face[(c + 1) % 3]));
      }
      std::sort(corners.begin(), corners.end());
      std::sort(mids.begin(), mids.end());
      mids_of_face[corners].push_back(mids);
    }
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0) << "unused nodes";
  int n_bad = 0;
  for (const auto& [corners, mids] : mids_of_face) n_bad += mids.size() > 2 || (mids.size() == 2 && mids[0] != mids[1]);
  EXPECT_EQ(n_bad, 0) << "faces that do not match";

  const SurfaceMesh surface = boundary_surface(mesh);
  std::map<std::array<int, 2>, int> directed;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) ++directed[{surface.triangles(t, c), surface.triangles(t, (c + 1) % 3)}];
  int n_open = 0;
  for (const auto& [edge, count] : directed) {
    const auto back = directed.find({edge[1], edge[0]});
    n_open += count != 1 || back == directed.end() || back->second != 1;
  }
  EXPECT_EQ(n_open, 0) << "edges of the boundary that do not close";
  EXPECT_FALSE(first_folded_element(mesh).has_value());
}

/// Expects an InputError whose text holds all the words.
template <class Call>
void expect_input_error(Call call, const std::vector<std::string>& words) {
  try {
    call();
    ADD_FAILURE() << "no InputError";
  } catch (const InputError& error) {
    for (const std::string& word : words)
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
          << "\"" << word << "\" not in: " << error.what();
  }
}

}  // namespace klang::mesh::test
