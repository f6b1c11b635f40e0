#pragma once
#include <array>
#include <vector>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::test {

/// A free body with the exact frequencies of its lowest elastic modes, each as often as its multiplicity says.
struct ReferenceBody {
  mesh::ShapeSpec shape;
  solid::Material material;
  std::vector<double> frequency_hz;
};

/// tests/reference/sphere_lamb.json: cases[0].example.f_Hz (Lamb's series), ball of 30 mm radius, nu = 0.29; 16 digits.
inline ReferenceBody reference_ball() {
  ReferenceBody body{{"sphere", {{"radius_m", 0.03}}, {}}, solid::from_youngs_modulus(200e9, 0.29, 7850), {}};
  const std::pair<double, int> modes[] = {
      {41697.10601444799, 5}, {44095.671685478315, 5}, {58507.821851427754, 3}, {64429.528866887034, 7}};
  for (const auto& [f, multiplicity] : modes) body.frequency_hz.insert(body.frequency_hz.end(), multiplicity, f);
  return body;
}

/// tests/reference/free_solids.json: ceramic_tile_100x100x8.f_Hz (Ritz; 3e-7).
inline ReferenceBody reference_tile() {
  return {{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.008}}, {}},
          {18541610192.46408, 30252100840.336136, 2700, "", ""},
          {2672.914462333648, 3924.049201190637, 4472.488132973063, 6648.325659608077, 6648.3256601532885,
           11193.565276399544, 11193.56527650146, 11750.340104747655, 12862.62362593311, 13786.58083845066,
           18659.734843032234, 18659.73484329457, 20625.74752179741, 20819.665573803944, 21167.037476567402}};
}

/// tests/reference/free_solids.json: aluminium_block_30x40x50.f_Hz (Ritz; 2e-7).
inline ReferenceBody reference_block() {
  return {{"box", {{"length_m", 0.03}, {"width_m", 0.04}, {"height_m", 0.05}}, {}},
          {49800000000.0, 25700000000.000008, 2700, "", ""},
          {26439.731509438734, 34721.54113923813, 38712.030995520116, 43305.6291623288, 46550.2135399402,
           47031.19198808217, 49313.687190078876, 49629.46646834014, 49866.003085277785, 52859.10015338861,
           54973.75124454294, 55964.86252981227, 56339.75189868073, 61081.24199672348, 61487.06749422619}};
}

/// tests/reference/chimes.json: tubes[i].ritz3d_bending (~7 digits); each frequency is that of a pair.
inline ReferenceBody reference_tube(double length_m) {
  const bool d3 = length_m == 0.505;
  return {{"tube", {{"length_m", length_m}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}},
          {4.98e10, 2.57e10, 2700, "", ""},
          d3 ? std::vector<double>{587.8831103242787, 1575.1159866675644, 2969.5312988027986, 4681.101830346376,
                                   6630.651833302586, 8750.000412714602}
             : std::vector<double>{1185.4672628861772, 3095.019228731142, 5657.745289217874, 8635.76762217711,
                                   11857.598902895208, 15199.348080467476}};
}

}  // namespace klang::test
