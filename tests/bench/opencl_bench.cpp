// Every kernel for OpenCL beside the processor's own code: one line per kernel with the card, the size, seconds on both (the device's
// with all transfers and the processor's share, compiled before) and the largest relative difference of what comes out.
//   opencl_bench [--device auto|cpu|INDEX|NAME] [--precision double|single] [--large] [--repeats N]
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/bem/detail/assembly.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/dual_domain/reciprocal.hpp"
#include "core/sound/transfer/transfer_opencl.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace {

using namespace klang;

struct Settings {
  opencl::DeviceChoice device{.used = true, .device = "auto"};
  bool large = false;
  int repeats = 3;
};

double best_of(int repeats, const std::function<void()>& work) {
  double best = HUGE_VAL;
  for (int i = 0; i < repeats; ++i) {
    const Stopwatch watch;
    work();
    best = std::min(best, watch.seconds());
  }
  return best;
}

std::string device_name(const Settings& settings) {
  const std::vector<opencl::Device> devices = opencl::devices();
  return devices[opencl::chosen_device(devices, settings.device.device)].name;
}

double difference(const Eigen::MatrixXcd& found, const Eigen::MatrixXcd& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

void line(const std::string& device, const char* kernel, const std::string& size, double device_s, double processor_s,
          double relative) {
  std::printf("%-28s %-34s %-44s %10.4g s %10.4g s %9.2g\n", device.c_str(), kernel, size.c_str(), device_s,
              processor_s, relative);
  std::fflush(stdout);
}

void transfer(const Settings& settings) {
  const acoustics::TransferModel model = acoustics::random_transfer(std::vector<int>(80, 26), 1);
  acoustics::OpenClTransfer device(model, settings.device.device, settings.device.precision);
  acoustics::TransferEvaluator processor(model);
  for (const int n : {1, 600}) {
    Eigen::Matrix3Xd x = Eigen::Matrix3Xd::Random(3, n);
    x.colwise().normalize();
    Eigen::MatrixXcd found, expected;
    device.evaluate(x, found);
    const double device_s = best_of(20, [&] { device.evaluate(x, found); });
    const double processor_s = best_of(20, [&] { processor.evaluate(x, expected); });
    line(device.device().name, "transfer of modes", "80 modes of order 26, " + std::to_string(n) + " listener(s)",
         device_s, processor_s, difference(found, expected));
  }
}

acoustics::RadiatingSurface sphere(int divisions) {
  return acoustics::radiating_surface(acoustics::geodesic_sphere(0.1, divisions));
}

/// Matrix and right-hand side, and the product, apart from the solution.
void boundary_elements(const Settings& settings, int divisions) {
  const acoustics::detail::BemGeometry geometry(sphere(divisions));
  const Eigen::Index n = geometry.surface.n_vertices();
  const Eigen::MatrixXcd derivative = Eigen::MatrixXcd::Random(3 * geometry.surface.n_triangles(), 2);
  const acoustics::detail::Assembly assembly(geometry, 6.0 * divisions, derivative);
  const std::string size = std::to_string(geometry.surface.n_triangles()) + " elements";
  la::RowMatrixXcd matrix;
  Eigen::MatrixXcd right, device_right, y;
  const double processor_s = best_of(1, [&] {
    matrix = la::RowMatrixXcd::Zero(n, n);
    right = Eigen::MatrixXcd::Zero(n, 2);
    parallel_for(static_cast<std::size_t>(n), 100,
                 [&](std::size_t begin, std::size_t end) { assembly.rows(begin, end, matrix, right); });
  });
  std::unique_ptr<acoustics::detail::DeviceSystem> system;
  double near_s = 0.0, device_s = HUGE_VAL;
  for (int i = 0; i < settings.repeats; ++i) {
    system.reset();
    const Stopwatch watch;
    device_right = Eigen::MatrixXcd::Zero(n, 2);
    const acoustics::detail::NearRows near = assembly.near_rows(device_right);
    const double near_now_s = watch.seconds();
    system = std::make_unique<acoustics::detail::DeviceSystem>(settings.device, assembly.far_problem(), near);
    device_right += system->far_right(assembly.at_points());
    if (watch.seconds() < device_s) {
      device_s = watch.seconds();
      near_s = near_now_s;
    }
  }
  const std::string& name = system->device().name;
  line(name, "boundary elements: assembly", size + " (near pairs " + std::to_string(near_s).substr(0, 5) + " s)",
       device_s, processor_s, std::max(difference(system->matrix(), matrix), difference(device_right, right)));
  const Eigen::MatrixXcd x = Eigen::MatrixXcd::Random(n, 1);
  Eigen::MatrixXcd expected(n, 1);
  const double product_s = best_of(settings.repeats, [&] { y = system->times(x); });
  const double own_s = best_of(settings.repeats, [&] {
    parallel_for(static_cast<std::size_t>(n), 100, [&](std::size_t begin, std::size_t end) {
      const auto first = static_cast<Eigen::Index>(begin), count = static_cast<Eigen::Index>(end - begin);
      expected.middleRows(first, count).noalias() = matrix.middleRows(first, count) * x;
    });
  });
  line(name, "boundary elements: product", std::to_string(n) + " unknowns", product_s, own_s, difference(y, expected));
}

/// One frequency from velocities to pressures; the processor factors, the device iterates.
void boundary_element_solution(const Settings& settings, int divisions, bool beside_processor) {
  using namespace acoustics;
  const HelmholtzBem solver(sphere(divisions));
  const Eigen::MatrixXcd velocity =
      solver.from_triangles(solver.surface().centroids_m.row(2).transpose().cast<std::complex<double>>());
  BemOptions options;
  const double hz = 6.0 * divisions * options.medium.sound_speed_m_s / (2.0 * 3.14159265358979);
  options.device = settings.device;
  BemResult found, expected;
  const double device_s = best_of(settings.repeats, [&] { found = solver.solve(hz, velocity, options); });
  std::string size = std::to_string(found.n_elements) + " elements, " + std::to_string(found.n_products) + " products";
  for (const char* part : {"near", "assemble", "solve"})
    size += ", " + std::to_string(found.wall_time_s[part]).substr(0, 5);
  double processor_s = 0.0, relative = 0.0;
  if (beside_processor) {
    options.device = {};
    processor_s = best_of(1, [&] { expected = solver.solve(hz, velocity, options); });
    relative = difference(found.pressure_pa, expected.pressure_pa);
  }
  line(found.device, "boundary elements: solution", size, device_s, processor_s, relative);
  if (!found.device_message.empty()) std::printf("  %s\n", found.device_message.c_str());
}

/// The air of a tank seen from two ears.
void reciprocal(const Settings& settings, bool large) {
  using namespace bubble;
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, large ? 0.0065 : 0.05));
  const EarElements elements(boundary, large ? 5000 : 300);
  const std::vector<Eigen::Vector3d> ears{{0.4, 0.3, 0.8}, {0.6, 0.3, 0.8}};
  Eigen::MatrixXcd found, expected;
  std::string message;
  const double device_s = best_of(
      settings.repeats, [&] { found = elements.field(2000.0, ears, {}, silent_monitor(), settings.device, &message); });
  const double processor_s = best_of(1, [&] { expected = elements.field(2000.0, ears, {}); });
  line(device_name(settings), "reciprocal: field of two ears", std::to_string(elements.n_elements()) + " elements",
       device_s, processor_s, difference(found, expected));
  if (!message.empty()) std::printf("  %s\n", message.c_str());
}

Settings settings_of(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    if (option == "--device") settings.device.device = value, ++i;
    if (option == "--precision")
      settings.device.precision = value == "single" ? opencl::Precision::kSingle : opencl::Precision::kDouble, ++i;
    if (option == "--repeats") settings.repeats = std::max(std::atoi(value.c_str()), 1), ++i;
    if (option == "--large") settings.large = true;
  }
  return settings;
}

}  // namespace

int main(int argc, char** argv) {
  const Settings settings = settings_of(argc, argv);
  std::printf("%d threads of the processor, %s precision on the device\n", thread_count(),
              settings.device.precision == opencl::Precision::kDouble ? "double" : "single");
  std::printf("%-28s %-34s %-44s %12s %12s %9s\n", "device", "kernel", "size", "device", "processor", "differs");
  try {
    transfer(settings);
    for (const int divisions : settings.large ? std::vector<int>{10, 23} : std::vector<int>{4}) {
      boundary_elements(settings, divisions);
      boundary_element_solution(settings, divisions, true);
    }
    reciprocal(settings, settings.large);
    if (settings.large)
      for (const int divisions : {40, 55}) boundary_element_solution(settings, divisions, false);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "opencl_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
