#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/physics/liquid_vdb/vdb_file.hpp"

namespace klang::liquid {
namespace {

/// A folder that is gone afterwards.
struct Scratch {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("klang-vdb-" + std::to_string(::getpid()));
  Scratch() {
    openvdb::initialize();
    std::filesystem::create_directories(path);
  }
  ~Scratch() { std::filesystem::remove_all(path); }
  std::filesystem::path write(const openvdb::GridBase::Ptr& grid, const std::string& name = "phi") const {
    grid->setName(name);
    const std::filesystem::path file = path / "a.vdb";
    openvdb::io::File(file.string()).write({grid});
    return file;
  }
};

openvdb::FloatGrid::Ptr ball(double half_width) {
  return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(0.1F, {0.2F, 0.0F, 0.3F}, 0.01F,
                                                                  static_cast<float>(half_width));
}

/// Of values at cells.
template <class Value>
Field filled(const GridShape& shape, Value&& value) {
  Field field(shape.nx, shape.ny, shape.nz);
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) field(i, j, k) = value(i, j, k);
  return field;
}

/// The complaint about a file, in one line.
std::string complaint(const std::filesystem::path& file) {
  try {
    const VdbFile vdb(file);
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "no complaint";
}

TEST(VdbFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const GridShape shape{4, 5, 6, 0.01};
  const Field phi = filled(shape, [](int, int, int k) { return 0.01 * (k - 2.3); });
  MacGrid u(shape);
  u[0](4, 2, 3) = 0.5;
  u[2](1, 4, 0) = -0.25;
  write_vdb(scratch.path / "b.vdb", shape, phi, u, 0.5);
  const VdbFile vdb(scratch.path / "b.vdb");
  EXPECT_LE(std::abs(vdb.extent().voxel - 0.01), 1e-12);
  EXPECT_LE((vdb.extent().first - Eigen::Vector3d::Constant(0.005)).norm(), 1e-12);
  EXPECT_EQ(vdb.extent().high, (std::array<int, 3>{3, 4, 5}));
  EXPECT_LE(std::abs(vdb.value(1, 2, 3) - phi(1, 2, 3)), 1e-8);
  EXPECT_LE(std::abs(vdb.value(3, 4, 0) - phi(3, 4, 0)), 1e-8) << "to full depth";
  ASSERT_TRUE(vdb.has_velocity());
  EXPECT_EQ(vdb.face_velocity(0, 4, 2, 3), 0.5);
  EXPECT_EQ(vdb.face_velocity(2, 1, 4, 0), -0.25);
}

TEST(VdbFile, SameLiquidGivesSameBytesAndAnotherOneAnotherNumber) {
  const Scratch scratch;
  const GridShape shape{9, 5, 6, 0.01};
  Field phi(9, 5, 6);
  for (std::size_t c = 0; c < phi.size(); ++c) phi[c] = 0.01 * std::sin(0.37 * static_cast<double>(c));
  const auto bytes = [&](const std::string& name) {
    write_vdb(scratch.path / name, shape, phi, MacGrid(shape), 0.25);
    std::ostringstream text;
    text << std::ifstream(scratch.path / name, std::ios::binary).rdbuf();
    return text.str();
  };
  const std::string first = bytes("first.vdb");
  EXPECT_EQ(first, bytes("second.vdb"));
  phi[17] += 0.001;
  EXPECT_NE(first.substr(21, 36), bytes("third.vdb").substr(21, 36));
  EXPECT_EQ(VdbFile(scratch.path / "first.vdb").extent().high[0], 8);
}

TEST(VdbFile, TakesABandOfOthersAndDistancesInVoxels) {
  const Scratch scratch;
  const VdbFile vdb(scratch.write(ball(3.0)));
  EXPECT_LE(std::abs(vdb.extent().band_voxels - 3.0), 0.5);
  EXPECT_FALSE(vdb.has_velocity());
  const auto in_voxels = ball(3.0);
  for (auto it = in_voxels->beginValueAll(); it; ++it) it.setValue(*it * 100.0F);
  in_voxels->tree().root().setBackground(3.0F, true);
  const VdbFile other(scratch.write(in_voxels));
  EXPECT_LE(std::abs(other.value(20, 0, 20) - vdb.value(20, 0, 20)), 2e-4);
  EXPECT_LE(std::abs(other.extent().band_voxels - vdb.extent().band_voxels), 2e-3);

  const auto thin = ball(2.0);  // as thin as is taken, in either unit
  EXPECT_LE(std::abs(VdbFile(scratch.write(thin)).extent().band_voxels - 2.0), 1e-3);
  for (auto it = thin->beginValueAll(); it; ++it) it.setValue(*it * 100.0F);
  thin->tree().root().setBackground(2.0F, true);
  EXPECT_LE(std::abs(VdbFile(scratch.write(thin)).extent().band_voxels - 2.0), 1e-3);
}

TEST(VdbFile, AVelocityThatIsNoNumberIsRefused) {
  const Scratch scratch;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto phi = ball(3.0);
    phi->setName("phi");
    const auto velocity = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0F));
    velocity->setName("velocity");
    velocity->setTransform(phi->transformPtr());
    velocity->getAccessor().setValue({20, 0, 20}, openvdb::Vec3s(0.0F, bad, 0.0F));
    const std::filesystem::path file = scratch.path / "n.vdb";
    openvdb::io::File(file.string()).write({phi, velocity});
    EXPECT_NE(complaint(file).find("velocity holds a value that is no number"), std::string::npos) << complaint(file);
  }
}

TEST(VdbFile, AFileThatTheDiskTakesInPartIsNotLeft) {
  const Scratch scratch;
  const GridShape shape{32, 32, 32, 0.01};
  const Field phi = filled(shape, [](int i, int j, int k) { return 0.01 * k - 0.16 + 1e-4 * ((7 * i + 5 * j) % 11); });
  write_vdb(scratch.path / "whole.vdb", shape, phi, std::nullopt, 0.0);
  const auto size = static_cast<rlim_t>(std::filesystem::file_size(scratch.path / "whole.vdb"));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t part : {size - 8, size / 2}) {
    const rlimit some{part, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &some), 0);
    EXPECT_THROW(write_vdb(scratch.path / "part.vdb", shape, phi, std::nullopt, 0.0), InputError) << part;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_FALSE(std::filesystem::exists(scratch.path / "part.vdb"));
  }
  std::signal(SIGXFSZ, handler);
}

class Stopped : public Monitor {
 public:
  bool stop_requested() const override { return true; }
};

TEST(VdbFile, ReadingHeedsAStop) {
  const Scratch scratch;
  const std::filesystem::path file = scratch.write(ball(3.0));
  Stopped stopped;
  EXPECT_THROW(VdbFile(file, "phi", stopped), Interrupted);
}

TEST(VdbFile, RefusesWhatDoesNotCarryALiquid) {
  const Scratch scratch;
  EXPECT_NE(complaint(scratch.write(ball(1.5))).find("too thin"), std::string::npos);
  EXPECT_NE(complaint(scratch.write(ball(3.0), "density")).find("no grid phi"), std::string::npos);
  auto flat = ball(3.0);
  auto transform = openvdb::math::Transform::createLinearTransform(0.01);
  transform->postScale(openvdb::Vec3d(1.0, 1.0, 2.0));
  flat->setTransform(transform);
  EXPECT_NE(complaint(scratch.write(flat)).find("no cubes"), std::string::npos);
  auto turned = ball(3.0);
  transform = openvdb::math::Transform::createLinearTransform(0.01);
  transform->postRotate(0.3);
  turned->setTransform(transform);
  EXPECT_NE(complaint(scratch.write(turned)).find("turned"), std::string::npos);
  EXPECT_NE(complaint(scratch.write(openvdb::FloatGrid::create(0.1F))).find("empty"), std::string::npos);
  EXPECT_NE(complaint(scratch.write(openvdb::Int32Grid::create(1))).find("no numbers"), std::string::npos);
  std::ofstream(scratch.path / "c.vdb") << "not a vdb";
  EXPECT_NE(complaint(scratch.path / "c.vdb").find("no usable .vdb"), std::string::npos);
}

TEST(VdbFile, RefusesSizesThatTheFileCannotHold) {
  const Scratch scratch;
  const std::filesystem::path file = scratch.write(ball(3.0));
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string good = text.str();
  const auto with = [&](std::size_t at, std::string_view bytes) {
    std::string broken = good;
    broken.replace(at, bytes.size(), bytes);
    std::ofstream(file, std::ios::binary) << broken;
    return complaint(file);
  };
  EXPECT_NE(with(0, "x").find("does not start as one"), std::string::npos);
  EXPECT_NE(with(8, "\x7f\x7f\x7f\x7f").find("version is unknown"), std::string::npos);
  // A string has its length before it: one of 3.7 GB.
  const std::size_t name = good.find("Tree_float");
  ASSERT_NE(name, std::string::npos);
  EXPECT_NE(with(name - 4, "\xe0\xe0\xe0\xe0").find("cut off"), std::string::npos);
  const std::size_t about = good.find("class", name);  // what is said about the grid is the library's to read
  ASSERT_NE(about, std::string::npos);
  EXPECT_NE(with(about - 4, "\xe0\xe0\xe0\xe0").find("more memory"), std::string::npos);
  for (std::size_t cut = 1; cut < good.size(); cut += cut + 300 < good.size() ? good.size() / 40 : 1) {
    std::ofstream(file, std::ios::binary) << good.substr(0, cut);
    EXPECT_NE(complaint(file).find("no usable .vdb"), std::string::npos) << cut;
  }
}

}  // namespace
}  // namespace klang::liquid
