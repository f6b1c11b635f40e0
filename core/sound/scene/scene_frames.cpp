#include "core/sound/scene/scene_frames.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/sound/scene/detail/deformed_glb.hpp"

namespace klang::scene {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

using detail::append;
using detail::GlbBuffers;
using detail::GlbKeys;

constexpr int kMostTriangles = 60'000, kFewestTriangles = 300;  // of a frame; of a body

Vector3d corner(const mesh::SurfaceMesh& surface, Eigen::Index triangle, int k) {
  return surface.vertices_m.row(surface.triangles(triangle, k)).transpose();
}

/// Triangles with a normal each, so that edges stay sharp.
json glb_mesh(const FrameBody& body, GlbBuffers& buffers) {
  std::vector<float> places, normals;
  for (Eigen::Index t = 0; t < body.surface->triangles.rows(); ++t) {
    const Vector3d a = corner(*body.surface, t, 0), b = corner(*body.surface, t, 1), c = corner(*body.surface, t, 2);
    const Vector3d n = (b - a).cross(c - a);
    if (!(n.norm() > 0.0)) continue;
    for (const Vector3d& p : {a, b, c})
      for (int axis = 0; axis < 3; ++axis) {
        places.push_back(static_cast<float>(p[axis]));
        normals.push_back(static_cast<float>(n[axis] / n.norm()));
      }
  }
  const int place = buffers.add(places, 3, true, true), normal = buffers.add(normals, 3, true, false);
  return {{"name", body.name},
          {"primitives",
           {{{"attributes", {{"POSITION", place}, {"NORMAL", normal}}}, {"material", body.material}, {"mode", 4}}}}};
}

json glb_materials(const Scene& scene) {
  constexpr double kColours[][3] = {{0.35, 0.55, 0.75}, {0.80, 0.55, 0.30}, {0.45, 0.65, 0.40}, {0.70, 0.40, 0.45},
                                    {0.55, 0.50, 0.70}, {0.65, 0.60, 0.40}, {0.45, 0.45, 0.45}};
  json materials = json::array();
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const double* const colour = kColours[i % std::size(kColours)];
    materials.push_back({{"name", scene.materials[i].name},
                         {"doubleSided", true},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}},
                           {"metallicFactor", 0.0},
                           {"roughnessFactor", 0.6}}}});
  }
  return materials;
}

/// What bodies that look alike have in common.
std::string look_of(const SceneBody& body) {
  std::string key = to_text(body.max_edge_m) + ";" + to_text(body.unit_m) + ";" + body.mesh.string();
  if (!body.shape) return key;
  key += body.shape->kind + ";" + body.shape->profile_csv.string();
  for (const auto& [name, value] : body.shape->dims) key += ";" + name + "=" + to_text(value);
  return key;
}

/// As many triangles as a picture needs.
mesh::SurfaceMesh coarse_enough(const mesh::SurfaceMesh& surface, int most) {
  mesh::SurfaceMesh straight = straight_surface(surface);
  try {
    return straight_surface(mesh::drawn_surface(straight, most));
  } catch (const InputError&) {
    return straight;
  }
}

}  // namespace

mesh::SurfaceMesh straight_surface(const mesh::SurfaceMesh& surface) {
  mesh::SurfaceMesh straight;
  std::vector<int> number(static_cast<std::size_t>(surface.vertices_m.rows()), -1);
  std::vector<int> kept;
  straight.triangles.resize(surface.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      int& own = number[static_cast<std::size_t>(surface.triangles(t, k))];
      if (own < 0) {
        own = static_cast<int>(kept.size());
        kept.push_back(surface.triangles(t, k));
      }
      straight.triangles(t, k) = own;
    }
  straight.vertices_m.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t v = 0; v < kept.size(); ++v)
    straight.vertices_m.row(static_cast<Eigen::Index>(v)) = surface.vertices_m.row(kept[v]);
  return straight;
}

std::vector<FrameBody> frame_bodies(const Scene& scene, Monitor& monitor) {
  std::map<std::string, std::shared_ptr<const mesh::SurfaceMesh>> known;
  std::vector<FrameBody> bodies;
  const int most = std::max(kFewestTriangles, kMostTriangles / static_cast<int>(scene.bodies.size()));
  for (const SceneBody& body : scene.bodies) {
    monitor.throw_if_stopped();
    auto& surface = known[look_of(body)];
    const bool deforms = body.deforms();
    if (!surface && !deforms)
      surface = std::make_shared<const mesh::SurfaceMesh>(
          coarse_enough(mesh::boundary_surface(mesh_of(body, {}, monitor)), most));
    FrameBody shown{body.name, body.material, deforms ? nullptr : surface, {}};
    shown.start.position_m = body.position_m;
    const Eigen::Quaterniond turn = orientation_of(body.rotation_deg);
    shown.start.orientation_wxyz = {turn.w(), turn.x(), turn.y(), turn.z()};
    bodies.push_back(std::move(shown));
  }
  return bodies;
}

events::Pose Frames::Shown::at(double time_s) const { return motion.poses().empty() ? body.start : motion.at(time_s); }

Frames::Frames(const Scene& scene, const events::EventLog& log, std::vector<FrameBody> bodies, double end_s,
               DeformedShapes shapes)
    : scene_(scene),
      shapes_(std::move(shapes)),
      low_m_(Vector3d::Constant(HUGE_VAL)),
      high_m_(Vector3d::Constant(-HUGE_VAL)) {
  KLANG_CHECK(bodies.size() == log.bodies.size(), "a surface for each body");
  std::vector<char> deforms(bodies.size(), 0);
  for (const DeformedBody& body : shapes_.bodies) deforms[static_cast<std::size_t>(body.row)] = 1;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int row = static_cast<int>(i), parent = log.bodies[i].parent;
    if (parent >= 0 && deforms[static_cast<std::size_t>(parent)] != 0) deforms[i] = 1;
    names_.push_back(bodies[i].name);
    materials_.push_back(bodies[i].material);
    if (deforms[i] != 0) {
      broken_s_.push_back(log.broken_s(row).value_or(HUGE_VAL));
      continue;
    }
    broken_s_.push_back(HUGE_VAL);
    KLANG_CHECK(bodies[i].surface != nullptr, "a body that does not deform has a surface");
    Shown shown{std::move(bodies[i]), log.motion_of(row), row, -HUGE_VAL, HUGE_VAL};
    if (parent >= 0) shown.from_s = log.broken_s(parent).value_or(0.0);
    shown.until_s = log.broken_s(row).value_or(HUGE_VAL);
    bodies_.push_back(std::move(shown));
  }
  const auto n = static_cast<std::size_t>(std::floor(end_s * scene.frames.rate_hz + 1e-9));
  for (std::size_t i = 0; i <= n; ++i) times_s_.push_back(static_cast<double>(i) / scene.frames.rate_hz);
  find_box();
}

void Frames::find_box() {
  for (const Shown& shown : bodies_) {
    const mesh::SurfaceMesh& surface = *shown.body.surface;
    const Vector3d middle = 0.5 * (surface.vertices_m.colwise().minCoeff() + surface.vertices_m.colwise().maxCoeff());
    const double radius = (surface.vertices_m.rowwise() - middle.transpose()).rowwise().norm().maxCoeff();
    for (const double time : times_s_) {
      if (!shown.is_there(time)) continue;
      const Vector3d place = shown.at(time).to_world(middle);
      low_m_ = low_m_.cwiseMin(place - Vector3d::Constant(radius));
      high_m_ = high_m_.cwiseMax(place + Vector3d::Constant(radius));
    }
  }
  for (const DeformedBody& body : shapes_.bodies)
    for (const DeformedFrame& frame : body.frames)
      for (std::size_t c = 0; c < frame.places_m.size(); c += 3) {
        const Vector3d place = Eigen::Vector3f(frame.places_m.data() + c).cast<double>();
        low_m_ = low_m_.cwiseMin(place);
        high_m_ = high_m_.cwiseMax(place);
      }
  if (scene_.floor_material) low_m_.z() = std::clamp(0.0, low_m_.z(), high_m_.z());
}

std::string Frames::glb() const {
  GlbBuffers buffers;
  GlbKeys keys;
  json nodes = json::array(), meshes = json::array(), children = json::array();
  std::map<std::pair<const mesh::SurfaceMesh*, int>, int> known;
  // glTF's y is the scene's z.
  nodes.push_back({{"name", scene_.name}, {"rotation", {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}}});
  for (const Shown& shown : bodies_) {
    const auto [mesh, is_new] =
        known.try_emplace({shown.body.surface.get(), shown.body.material}, static_cast<int>(meshes.size()));
    if (is_new) meshes.push_back(glb_mesh(shown.body, buffers));
    const int node = static_cast<int>(nodes.size());
    children.push_back(node);
    const events::Pose start = shown.at(std::max(0.0, shown.from_s));
    const Eigen::Vector4d& q = start.orientation_wxyz;
    nodes.push_back({{"name", shown.body.name},
                     {"mesh", mesh->second},
                     {"translation", {start.position_m.x(), start.position_m.y(), start.position_m.z()}},
                     {"rotation", {q[1], q[2], q[3], q[0]}}});
    if (shown.motion.moves()) {
      std::vector<float> times, places, turns;
      Eigen::Vector4d before = q;
      for (const double time : times_s_) {
        if (!times.empty() && !shown.is_there(time)) continue;
        const events::Pose pose = shown.at(time);
        Eigen::Vector4d turn = pose.orientation_wxyz;
        if (turn.dot(before) < 0.0) turn = -turn;  // the short way from key to key
        before = turn;
        times.push_back(static_cast<float>(time));
        for (int axis = 0; axis < 3; ++axis) places.push_back(static_cast<float>(pose.position_m[axis]));
        for (const int part : {1, 2, 3, 0}) turns.push_back(static_cast<float>(turn[part]));
      }
      keys.add(node, {"translation", 3, "LINEAR"}, times, places, buffers);
      keys.add(node, {"rotation", 4, "LINEAR"}, times, turns, buffers);
    }
    std::vector<float> times = {0.0F}, sizes(3, shown.from_s > 0.0 ? 0.0F : 1.0F);
    for (const auto& [time, size] : {std::pair(shown.from_s, 1.0F), std::pair(shown.until_s, 0.0F)}) {
      if (!std::isfinite(time) || !(static_cast<float>(time) > times.back())) continue;
      times.push_back(static_cast<float>(time));
      sizes.insert(sizes.end(), 3, size);
    }
    if (times.size() > 1) keys.add(node, {"scale", 3, "STEP"}, times, sizes, buffers);
  }
  for (const DeformedBody& body : shapes_.bodies) {
    const auto row = static_cast<std::size_t>(body.row);
    detail::add_deformed_body(body, names_[row], materials_[row], scene_.frames.rate_hz,
                              {buffers, keys, nodes, meshes, children});
  }
  nodes[0]["children"] = children;
  json document = {{"asset", {{"version", "2.0"}, {"generator", "Klangprobe"}}},
                   {"scene", 0},
                   {"scenes", {{{"name", scene_.name}, {"nodes", {0}}}}},
                   {"nodes", nodes},
                   {"meshes", meshes},
                   {"materials", glb_materials(scene_)},
                   {"accessors", buffers.accessors},
                   {"bufferViews", buffers.views}};
  if (!keys.channels.empty())
    document["animations"] = {{{"name", "motion"}, {"channels", keys.channels}, {"samplers", keys.samplers}}};
  return detail::glb_bytes(std::move(document), std::move(buffers.bytes));
}

std::string Frames::vtp(std::size_t frame) const {
  const double time = times_s_.at(frame);
  std::string points, corners, ends, owners;
  std::int32_t n_points = 0, n_triangles = 0;
  for (const Shown& shown : bodies_) {
    if (!shown.is_there(time)) continue;
    const mesh::SurfaceMesh& surface = *shown.body.surface;
    const events::Pose pose = shown.at(time);
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      for (int k = 0; k < 3; ++k) append<std::int32_t>(corners, n_points + surface.triangles(t, k));
      append<std::int32_t>(ends, 3 * ++n_triangles);
      append<std::int32_t>(owners, shown.row);
    }
    for (Eigen::Index v = 0; v < surface.vertices_m.rows(); ++v) {
      const Vector3d place = pose.to_world(surface.vertices_m.row(v).transpose());
      for (int axis = 0; axis < 3; ++axis) append(points, static_cast<float>(place[axis]));
    }
    n_points += static_cast<std::int32_t>(surface.vertices_m.rows());
  }
  for (const DeformedBody& body : shapes_.bodies) {
    // Of frames that are kept the last until then.
    const auto after =
        std::upper_bound(body.frames.begin(), body.frames.end(), static_cast<std::int32_t>(frame),
                         [](std::int32_t number, const DeformedFrame& kept) { return number < kept.number; });
    KLANG_CHECK(after != body.frames.begin(), "its first frame is that at 0 s");
    const DeformedFrame& shown = *(after - 1);
    const DeformedSurface& surface = body.surfaces[static_cast<std::size_t>(shown.surface)];
    const bool is_broken = shown.number / scene_.frames.rate_hz >= broken_s_[static_cast<std::size_t>(body.row)];
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      for (const std::int32_t corner : surface.triangles[t]) append<std::int32_t>(corners, n_points + corner);
      append<std::int32_t>(ends, 3 * ++n_triangles);
      append<std::int32_t>(owners, is_broken ? surface.rows[t] : body.row);
    }
    for (const float value : shown.places_m) append(points, value);
    n_points += static_cast<std::int32_t>(shown.places_m.size() / 3);
  }
  std::string data;
  const auto array = [&](const std::string& attributes, const std::string& bytes) {
    std::string element =
        "<DataArray " + attributes + " format=\"appended\" offset=\"" + std::to_string(data.size()) + "\"/>\n";
    append<std::uint64_t>(data, bytes.size());
    data += bytes;
    return element;
  };
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      std::to_string(n_points) + "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
      std::to_string(n_triangles) + "\">\n<CellData>\n";
  text += array("type=\"Int32\" Name=\"body\"", owners) + "</CellData>\n<Points>\n";
  text += array("type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"", points) + "</Points>\n<Polys>\n";
  text += array("type=\"Int32\" Name=\"connectivity\"", corners);
  text += array("type=\"Int32\" Name=\"offsets\"", ends);
  text += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  return text + data + "\n</AppendedData>\n</VTKFile>\n";
}

std::string Frames::vtp_name(std::size_t frame) {
  const std::string digits = std::to_string(frame);
  return "frames/" + std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".vtp";
}

std::string Frames::pvd() const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (std::size_t i = 0; i < times_s_.size(); ++i)
    text += "<DataSet timestep=\"" + to_text(times_s_[i]) + "\" part=\"0\" file=\"" + vtp_name(i) + "\"/>\n";
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace klang::scene
