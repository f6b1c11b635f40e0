// Poles and shapes of frequency responses and free decays, against systems of two and three masses whose truth is exact.
#include <gtest/gtest.h>
#include <matio.h>

#include <Eigen/Eigenvalues>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "fit/frf/response_analysis.hpp"

namespace klang::fit {
namespace {

using Complex = std::complex<double>;

/// Masses in a row between springs, damped in proportion to their stiffness and in one place more (so that shapes are complex).
struct Chain {
  Eigen::MatrixXd m, c, k;
  std::vector<Complex> poles;  ///< omega > 0, ascending
  Eigen::MatrixXcd shapes;     ///< columns
};

Chain chain(double extra_damping) {
  Chain chain;
  chain.m = Eigen::Vector3d(1.0, 1.5, 0.8).asDiagonal();
  chain.k = 1e6 * (Eigen::Matrix3d() << 3, -1, 0, -1, 2.5, -1.2, 0, -1.2, 2).finished();
  chain.c = 2e-6 * chain.k;
  chain.c(0, 0) += extra_damping;
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(6, 6);
  state.topRightCorner(3, 3).setIdentity();
  state.bottomLeftCorner(3, 3) = -chain.m.inverse() * chain.k;
  state.bottomRightCorner(3, 3) = -chain.m.inverse() * chain.c;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(state);
  std::vector<int> order;
  for (int i = 0; i < 6; ++i)
    if (solver.eigenvalues()[i].imag() > 0) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return solver.eigenvalues()[a].imag() < solver.eigenvalues()[b].imag(); });
  chain.shapes.resize(3, 3);
  for (int i = 0; i < 3; ++i) {
    chain.poles.push_back(solver.eigenvalues()[order[static_cast<std::size_t>(i)]]);
    chain.shapes.col(i) = solver.eigenvectors().col(order[static_cast<std::size_t>(i)]).head(3);
  }
  return chain;
}

ResponseSet frf_of(const Chain& chain, int derivative, double noise) {
  ResponseSet set;
  set.origin = "chain";
  set.derivative = derivative;
  set.abscissa = Eigen::VectorXd::LinSpaced(1600, 20, 420);
  set.values.resize(3, 1600);
  for (Eigen::Index i = 0; i < 1600; ++i) {
    const Complex s(0, 2 * std::numbers::pi * set.abscissa[i]);
    const Eigen::Matrix3cd z = s * s * chain.m.cast<Complex>() + s * chain.c.cast<Complex>() + chain.k.cast<Complex>();
    set.values.col(i) = std::pow(s, derivative) * z.inverse().col(0);
  }
  std::srand(7);
  for (Eigen::Index r = 0; r < 3; ++r) {
    const double size = noise * set.values.row(r).norm() / 40;
    for (Eigen::Index i = 0; i < 1600; ++i)
      set.values(r, i) +=
          size * Complex(Eigen::internal::random<double>(-1, 1), Eigen::internal::random<double>(-1, 1));
  }
  for (int i = 0; i < 3; ++i) set.points.push_back({i + 1, 3});
  return set;
}

void expect_truth(const ResponseAnalysis& result, const Chain& chain, double frequency, double decay, double mac) {
  ASSERT_TRUE(result.usable()) << result.message;
  ASSERT_EQ(result.partials.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const AnalysisPartial& p = result.partials[k];
    EXPECT_LE(std::abs(p.frequency_hz / (chain.poles[k].imag() / (2 * std::numbers::pi)) - 1), frequency);
    EXPECT_LE(std::abs(*p.decay_per_s / -chain.poles[k].real() - 1), decay);
    Eigen::VectorXcd shape(3);
    for (int i = 0; i < 3; ++i)
      shape[i] = {p.shape[static_cast<std::size_t>(i)][0], p.shape[static_cast<std::size_t>(i)][1]};
    EXPECT_GE(assurance(shape, chain.shapes.col(static_cast<Eigen::Index>(k))), 1 - mac);
  }
}

class ChainResponses : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Derivatives, ChainResponses, ::testing::Values(0, 1, 2));

TEST_P(ChainResponses, GiveTheExactPolesAndComplexShapes) {
  const Chain truth = chain(4.0);
  const ResponseAnalysis result = analyse_responses(frf_of(truth, GetParam(), 0), {{20, 420}});
  expect_truth(result, truth, 1e-7, 1e-5, 1e-8);
  EXPECT_GE(result.explained_energy, 1 - 1e-9);
  for (const char* estimator : {"least_squares", "lscf", "era"})
    EXPECT_EQ(std::count_if(result.record.estimates.begin(), result.record.estimates.end(),
                            [&](const PoleEstimate& e) { return e.estimator == estimator; }),
              3)
        << estimator;
}

TEST(Responses, NoiseMovesPolesByTheirStandardDeviations) {
  const Chain truth = chain(4.0);
  const ResponseAnalysis result = analyse_responses(frf_of(truth, 2, 0.05), {{20, 420}});
  expect_truth(result, truth, 2e-4, 0.05, 1e-3);
  for (std::size_t k = 0; k < 3; ++k) {
    const AnalysisPartial& p = result.partials[k];
    EXPECT_LE(std::abs(p.frequency_hz - truth.poles[k].imag() / (2 * std::numbers::pi)), 4 * *p.frequency_std_hz);
    EXPECT_LE(std::abs(*p.decay_per_s + truth.poles[k].real()), 4 * *p.decay_std_per_s);
  }
}

TEST(Responses, NoiseAloneIsRefused) {
  ResponseSet set = frf_of(chain(0), 2, 0);
  std::srand(3);
  for (Complex& value : set.values.reshaped())
    value = {Eigen::internal::random<double>(-1, 1), Eigen::internal::random<double>(-1, 1)};
  EXPECT_FALSE(analyse_responses(set, {{20, 420}}).usable());
}

TEST(Responses, NoiseOnFewLinesIsRefusedToo) {
  for (const int n : {16, 24, 40, 60}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      ResponseSet set;
      set.origin = "noise";
      set.abscissa = Eigen::VectorXd::LinSpaced(n, 20, 420);
      set.values.resize(1, n);
      set.points.push_back({1, 3});
      std::srand(seed);
      for (Complex& value : set.values.reshaped())
        value = {Eigen::internal::random<double>(-1, 1), Eigen::internal::random<double>(-1, 1)};
      EXPECT_FALSE(analyse_responses(set, {{20, 420}}).usable()) << n << " lines, seed " << seed;
    }
  }
}

TEST(Responses, WhatRingsAboveTheBandOfADecayIsNotFoundWithinIt) {
  ResponseSet set;
  set.origin = "decay";
  set.in_time = true;
  set.abscissa = Eigen::VectorXd::LinSpaced(16384, 0, 16383 / 16384.0);
  set.values.resize(1, 16384);
  set.points.push_back({1, 3});
  for (Eigen::Index i = 0; i < 16384; ++i) {
    const double t = set.abscissa[i];
    set.values(0, i) = std::exp(-8 * t) * std::sin(2 * std::numbers::pi * 150 * t) +
                       0.5 * std::exp(-9 * t) * std::sin(2 * std::numbers::pi * 1087 * t);
  }
  const ResponseAnalysis result = analyse_responses(set, {{20, 400}});
  ASSERT_TRUE(result.usable()) << result.message;
  ASSERT_EQ(result.partials.size(), 1U);
  EXPECT_NEAR(result.partials[0].frequency_hz, 150, 0.05);
}

TEST(Responses, FreeDecaysGiveTheSame) {
  const Chain truth = chain(4.0);
  ResponseSet set;
  set.origin = "decays";
  set.in_time = true;
  set.abscissa = Eigen::VectorXd::LinSpaced(2048, 0, 2047 / 2048.0);
  set.values = Eigen::MatrixXcd::Zero(3, 2048);
  for (std::size_t k = 0; k < 3; ++k)
    for (Eigen::Index i = 0; i < 2048; ++i)
      set.values.col(i) +=
          (truth.shapes.col(static_cast<Eigen::Index>(k)) * std::exp(truth.poles[k] * set.abscissa[i]) /
           truth.shapes.col(static_cast<Eigen::Index>(k)).norm())
              .real();
  for (int i = 0; i < 3; ++i) set.points.push_back({i + 1, 3});
  expect_truth(analyse_responses(set, {{20, 420}}), truth, 1e-7, 1e-5, 1e-8);
}

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// Dataset 58 of a set, text: double precision, or single in columns of 13 without blanks between.
std::string universal(const ResponseSet& set, bool twice) {
  std::string text;
  for (Eigen::Index r = 0; r < set.n_responses(); ++r) {
    text += "    -1\n    58\nNONE\nNONE\n27-Nov-26 12:00:00\nNONE\nNONE\n";
    char line[200];
    std::snprintf(line, sizeof line, "%5d%10d%5d%10d %10s%10d%4d %10s%10d%4d\n", 4, 0, 0, 0, "NONE",
                  static_cast<int>(r) + 1, 3, "NONE", 1, 3);
    text += line;
    std::snprintf(line, sizeof line, "%10d%10d%10d%13.5e%13.5e%13.5e\n", twice ? 6 : 5, static_cast<int>(set.n_lines()),
                  1, set.abscissa[0], set.abscissa[1] - set.abscissa[0], 0.0);
    text += line;
    text += "        18    0    0    0 Frequency            Hz                  \n";
    text += "        12    0    0    0 Acceleration         m/s^2               \n";
    text += "        13    0    0    0 Force                N                   \n";
    text += "         0    0    0    0 NONE                 NONE                \n";
    for (Eigen::Index i = 0; i < set.n_lines(); ++i) {
      for (const double part : {set.values(r, i).real(), set.values(r, i).imag()})
        text += number(twice ? "%20.11e" : "%13.5e", part);
      if (twice ? i % 2 == 1 : i % 3 == 2) text += "\n";
    }
    text += "\n    -1\n";
  }
  return text;
}

TEST(UniversalFile, TextOfEitherPrecisionIsRead) {
  ResponseSet set = frf_of(chain(4.0), 2, 0);
  set.abscissa = Eigen::VectorXd::LinSpaced(1600, 20, 419.75);  // 0.25 Hz: exact in five digits
  for (const bool twice : {true, false}) {
    const ResponseSet read = read_universal_bytes(universal(set, twice), "a.uff");
    ASSERT_EQ(read.n_responses(), 3);
    EXPECT_EQ(read.derivative, 2);
    EXPECT_FALSE(read.in_time);
    EXPECT_EQ(read.points[1].node, 2);
    EXPECT_EQ(read.points[1].direction, 3);
    EXPECT_LE((read.values - set.values).norm() / set.values.norm(), twice ? 1e-10 : 1e-5);
    EXPECT_LE((read.abscissa - set.abscissa).norm(), 1e-9);
  }
}

TEST(UniversalFile, DamageIsRefusedInOneLine) {
  const std::string whole = universal(frf_of(chain(4.0), 2, 0), true);
  EXPECT_THROW(read_universal_bytes("", "a.uff"), InputError);
  EXPECT_THROW(read_universal_bytes("RIFF....WAVE", "a.uff"), InputError);
  EXPECT_THROW(read_universal_bytes(whole.substr(0, whole.size() / 2), "a.uff"), InputError);
  std::string letters = whole;
  letters.replace(letters.find("e-0", 900), 3, "xyz");
  EXPECT_THROW(read_universal_bytes(letters, "a.uff"), InputError);
  std::string huge = whole;
  huge.replace(huge.find("      1600"), 10, "2000000000");
  EXPECT_THROW(read_universal_bytes(huge, "a.uff"), InputError);
  std::string other = whole;
  for (std::size_t at; (at = other.find("\n    4         0")) != std::string::npos;) other[at + 5] = '2';
  EXPECT_THROW(read_universal_bytes(other, "a.uff"), InputError) << "spectra are no responses";
}

TEST(UniversalFile, WhatItMeansIsReadOrRefused) {
  const std::string whole = universal(frf_of(chain(4.0), 2, 0), true);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    EXPECT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::string head = "NONE         1   3 ";
  EXPECT_THROW(read_universal_bytes(changed(head, "NONE         1   4 "), "a.uff"), InputError) << "a rotation";
  EXPECT_THROW(read_universal_bytes(changed(head, "NONE         19999 "), "a.uff"), InputError) << "no axis";
  EXPECT_THROW(read_universal_bytes(changed("        18    0", "        19    0"), "a.uff"), InputError)
      << "not over frequency";
  EXPECT_THROW(read_universal_bytes(changed("        13    0", "        12    0"), "a.uff"), InputError)
      << "transmissibility";
  std::string pressure = changed("        12    0", "        15    0");
  pressure.replace(pressure.find("m/s^2"), 5, "Pa   ");
  EXPECT_THROW(read_universal_bytes(pressure, "a.uff"), InputError) << "a pressure";
  std::string second = whole;
  const std::string reference = "NONE         1   3\n";
  second.replace(second.rfind(reference), reference.size(), "NONE         2   3\n");
  EXPECT_THROW(read_universal_bytes(second, "a.uff"), InputError) << "two places of the force";
}

void write_mat(const std::filesystem::path& path, const ResponseSet& set, const char* unit, bool sideways = false) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  std::size_t one[2] = {1, static_cast<std::size_t>(set.n_lines())};
  matvar_t* f =
      Mat_VarCreate("frequency_hz", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, one, const_cast<double*>(set.abscissa.data()), 0);
  Mat_VarWrite(file, f, MAT_COMPRESSION_ZLIB);
  Mat_VarFree(f);
  Eigen::MatrixXcd values = set.values;
  if (sideways) values.transposeInPlace();
  Eigen::MatrixXd re = values.real(), im = values.imag();
  mat_complex_split_t split{re.data(), im.data()};
  std::size_t dims[2] = {static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())};
  matvar_t* h = Mat_VarCreate("frf", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, &split, MAT_F_COMPLEX);
  Mat_VarWrite(file, h, MAT_COMPRESSION_NONE);
  Mat_VarFree(h);
  if (unit) {
    std::string text = unit;
    std::size_t length[2] = {1, text.size()};
    matvar_t* u = Mat_VarCreate("unit", MAT_C_CHAR, MAT_T_UINT8, 2, length, text.data(), 0);
    Mat_VarWrite(file, u, MAT_COMPRESSION_NONE);
    Mat_VarFree(u);
  }
  Mat_Close(file);
}

TEST(MatFile, VariablesAreReadAndHeldAgainstEachOther) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "klang-frf-test.mat";
  const ResponseSet set = frf_of(chain(4.0), 1, 0);
  write_mat(path, set, "m/s/N");
  const ResponseSet read = read_responses(path);
  EXPECT_EQ(read.derivative, 1);
  EXPECT_EQ(read.unit, "m/s/N");
  EXPECT_LE((read.values - set.values).norm(), 0.0);
  EXPECT_LE((read.abscissa - set.abscissa).norm(), 0.0);
  write_mat(path, set, "furlong");
  EXPECT_THROW(read_responses(path), InputError);
  write_mat(path, set, nullptr);
  EXPECT_THROW(read_responses(path), InputError);
  write_mat(path, set, "m/N", true);
  EXPECT_THROW(read_responses(path), InputError);
  write_file(path, "no such thing");
  EXPECT_THROW(read_responses(path), InputError);
  std::filesystem::remove(path);
}

TEST(Units, SayWhichDerivativeTheyAre) {
  for (const char* unit : {"m/s^2/N", "(m/s^2)/N", "m/s2/N", "m/(s^2 N)", "g/N", "1/kg", "m s^-2/N"})
    EXPECT_EQ(derivative_of_unit(unit, "t"), 2) << unit;
  for (const char* unit : {"m/s/N", "mm/s/N", "m/(N s)"}) EXPECT_EQ(derivative_of_unit(unit, "t"), 1) << unit;
  for (const char* unit : {"m/N", "um/N"}) EXPECT_EQ(derivative_of_unit(unit, "t"), 0) << unit;
  EXPECT_THROW(derivative_of_unit("Pa", "t"), InputError);
}

TEST(Shapes, AreHeldAgainstTheModelsByTheirAssurance) {
  modal::ModalModel model;
  model.mesh.nodes_m = Eigen::MatrixXd::Zero(5, 3);
  for (int i = 0; i < 5; ++i) model.mesh.nodes_m(i, 0) = 0.1 * i;
  model.angular_frequency_rad_s = Eigen::Vector2d(600, 1200);
  model.shapes = Eigen::MatrixXd::Zero(15, 2);
  for (int i = 0; i < 5; ++i)
    model.shapes(3 * i + 2, 0) = i - 2.0, model.shapes(3 * i + 2, 1) = (i - 2.0) * (i - 2.0) - 2;
  ResponseSet set;
  set.values.resize(3, 16);
  ResponseAnalysis analysis;
  analysis.partials.resize(1);
  for (int i = 0; i < 3; ++i) {
    set.points.push_back({i, i == 1 ? -3 : 3});
    set.nodes_m[i] = {0.2 * i + 0.004, 0, 0};
    analysis.partials[0].shape.push_back({(i == 1 ? -1 : 1) * ((2.0 * i - 2) * (2.0 * i - 2) - 2), 0.0});
  }
  compare_with_model(set, model, analysis);
  EXPECT_EQ(analysis.partials[0].model_mode, 1);
  EXPECT_NEAR(analysis.record.mac[0][1], 1.0, 1e-12);
  EXPECT_LE(analysis.record.mac[0][0], 1e-12);
  set.nodes_m[1][1] = 0.1;
  EXPECT_THROW(compare_with_model(set, model, analysis), InputError);
}

}  // namespace
}  // namespace klang::fit
