#include "core/sound/transfer/transfer_model_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/transfer/radiate_progress.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace klang::acoustics {
namespace {

std::filesystem::path scratch(const char* name) { return std::filesystem::path(testing::TempDir()) / name; }

TEST(TransferModelFile, ReadsBackEveryBit) {
  TransferModel model = random_transfer({0, 4, 17, 4}, 21);
  model.medium = {1.2041000000000002, 343.00000000000006};
  model.modes[1].residual = 1e-7 / 3.0;
  model.modes[2].multipole.coefficients_pa[5] = {5e-324, -0.0};
  const auto path = scratch("transfer.vtu");
  write_transfer_model(path, model, R"({"command": "a \"b\" <c>"})");
  const TransferModel back = read_transfer_model(path);
  EXPECT_EQ(back.medium.density_kg_m3, model.medium.density_kg_m3);
  EXPECT_EQ(back.medium.sound_speed_m_s, model.medium.sound_speed_m_s);
  ASSERT_EQ(back.modes.size(), model.modes.size());
  for (std::size_t i = 0; i < model.modes.size(); ++i) {
    const ModeTransfer &a = model.modes[i], &b = back.modes[i];
    EXPECT_EQ(a.mode, b.mode);
    EXPECT_EQ(a.frequency_hz, b.frequency_hz);
    EXPECT_EQ(a.radiated_power_w, b.radiated_power_w);
    EXPECT_EQ(a.decay_radiation_per_s, b.decay_radiation_per_s);
    EXPECT_EQ(a.kept_power_fraction, b.kept_power_fraction);
    EXPECT_EQ(a.n_bem_elements, b.n_bem_elements);
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.multipole.centre_m, b.multipole.centre_m);
    EXPECT_EQ(a.multipole.wavenumber_per_m, b.multipole.wavenumber_per_m);
    EXPECT_EQ(a.multipole.order, b.multipole.order);
    EXPECT_EQ(a.multipole.coefficients_pa, b.multipole.coefficients_pa);
  }
  EXPECT_EQ(read_transfer_provenance(path), R"({"command": "a \"b\" <c>"})");
  const auto again = scratch("transfer-again.vtu");
  write_transfer_model(again, back, R"({"command": "a \"b\" <c>"})");
  EXPECT_EQ(read_file(path), read_file(again));
}

TEST(TransferModelFile, HoldsAModelWithoutModes) {
  const auto path = scratch("transfer-empty.vtu");
  write_transfer_model(path, {});
  EXPECT_TRUE(read_transfer_model(path).modes.empty());
}

TEST(TransferModelFile, DamagedFilesAreInputErrors) {
  const auto path = scratch("transfer-whole.vtu"), broken = scratch("transfer-broken.vtu");
  write_transfer_model(path, random_transfer({3, 5}, 22));
  const std::string bytes = read_file(path);
  for (const double share : {0.0, 0.1, 0.5, 0.9}) {
    write_file(broken,
               std::string_view(bytes).substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    EXPECT_THROW(read_transfer_model(broken), InputError) << share;
  }
  // Headers that lie: more points than the file could hold, and another number than its arrays have.
  for (const std::string& lie : {std::string("NumberOfPoints=\"2000000000\""), std::string("NumberOfPoints=\"3\"")}) {
    std::string text = bytes;
    const std::size_t at = text.find("NumberOfPoints=\"");
    ASSERT_NE(at, std::string::npos);
    text.replace(at, text.find('"', at + 16) + 1 - at, lie);
    write_file(broken, text);
    EXPECT_THROW(read_transfer_model(broken), InputError) << lie;
  }
  TransferModel bad = random_transfer({3}, 23);
  bad.modes[0].multipole.coefficients_pa[2] = std::nan("");
  write_transfer_model(broken, bad);
  EXPECT_THROW(read_transfer_model(broken), InputError);
  EXPECT_THROW(read_transfer_model(scratch("no such transfer.vtu")), InputError);
}

TEST(TransferModelFile, RefusesTheTransferOfAnotherModel) {
  modal::ModalModel model;
  model.angular_frequency_rad_s = 2 * kPi * Eigen::Vector3d(100.0, 200.0, 300.0);
  TransferModel transfer = random_transfer({1, 1}, 24);
  transfer.modes[0].mode = 1;
  transfer.modes[0].frequency_hz = 200.0;
  transfer.modes[1].mode = 2;
  transfer.modes[1].frequency_hz = 300.0;
  EXPECT_NO_THROW(check_belongs(transfer, model, "t.vtu"));
  transfer.modes[1].frequency_hz = 300.1;
  EXPECT_THROW(check_belongs(transfer, model, "t.vtu"), InputError);
  transfer.modes[1].mode = 3;
  EXPECT_THROW(check_belongs(transfer, model, "t.vtu"), InputError);
}

TEST(RadiateProgress, GoesOnWithTheSameKeyOnlyAndInOrderOfModes) {
  const auto path = scratch("progress.vtu");
  std::filesystem::remove(path);
  const TransferModel model = random_transfer({2, 3}, 5);
  {
    RadiateProgress progress(path, "key", model.medium);
    EXPECT_TRUE(progress.modes().empty());
    progress.add(model.modes[1]);
    progress.add(model.modes[0]);
  }
  const RadiateProgress again(path, "key", model.medium);
  ASSERT_EQ(again.modes().size(), 2U);
  EXPECT_EQ(again.modes()[0].mode, model.modes[0].mode);
  EXPECT_EQ(again.modes()[1].multipole.coefficients_pa, model.modes[1].multipole.coefficients_pa);
  EXPECT_TRUE(RadiateProgress(path, "another key", model.medium).modes().empty());
  again.remove();
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RadiateProgress, AFileThatMakesNoSenseCountsAsNone) {
  const auto path = scratch("damaged.vtu");
  write_file(path, "no transfer model");
  const RadiateProgress progress(path, "key", {});
  EXPECT_TRUE(progress.unreadable());
  EXPECT_TRUE(progress.modes().empty());
}

}  // namespace
}  // namespace klang::acoustics
