// The compiled half of the Python package klangprobe: commands, and sounds as numpy arrays. apps/python/klangprobe/__init__.py gives
// them their shape.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <mutex>

#include "apps/commands/commands.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "core/sound/instrument/modal_bank.hpp"
#include "fit/instrument/banks.hpp"
#include "fit/instrument/fitted_body.hpp"
#include "fit/ringdown/analysis_document.hpp"

namespace py = pybind11;
using namespace klang;

namespace {

using Samples = py::array_t<double, py::array::f_style | py::array::forcecast>;

/// @return what the command warned of
std::vector<std::string> call(const std::vector<std::string>& words) {
  const py::gil_scoped_release released;
  static std::mutex one_at_a_time;  // commands set the number of threads and tell one hearer of their warnings
  const std::lock_guard lock(one_at_a_time);
  std::vector<std::string> warnings;
  struct Hearing {
    explicit Hearing(std::vector<std::string>& heard) {
      apps::set_warning_hearer([&heard](std::string_view text) { heard.emplace_back(text); });
    }
    ~Hearing() { apps::set_warning_hearer({}); }
  } const hearing(warnings);
  apps::Program program(apps::all_commands());
  program.call(words);
  return warnings;
}

/// The options of a command ("bubble info") in the words of Python, each with whether it takes a value.
std::map<std::string, bool> options(const std::string& command) {
  const apps::Program program(apps::all_commands());
  std::map<std::string, bool> takes_value;
  for (const CLI::App* app : program.commands()) {
    if (program.path_of(*app) != "klang " + command) continue;
    for (const CLI::Option* option : app->get_options()) {
      for (std::string name : option->get_lnames()) {
        std::replace(name.begin(), name.end(), '-', '_');
        takes_value[name] = option->get_items_expected_max() > 0;
      }
    }
  }
  return takes_value;
}

/// "; did you mean WORD", or nothing.
std::string meant(const std::string& word, const std::vector<std::string>& known) { return did_you_mean(word, known); }

/// @param samples  n_frames, or n_frames x n_channels
std::string analyze(const Samples& samples, double rate_hz, double a4_hz, double low_hz, double high_hz) {
  audio::Signal signal;
  signal.sample_rate_hz = rate_hz;
  if (samples.ndim() < 1 || samples.ndim() > 2)
    throw InputError("samples", "must have one or two dimensions", std::to_string(samples.ndim()));
  const Eigen::Index n = samples.shape(0), n_channels = samples.ndim() == 2 ? samples.shape(1) : 1;
  if (!(rate_hz > 0.0)) throw InputError("rate", "is out of range", to_text(rate_hz), "above 0");
  checked("analyze", "a4_hz", a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  signal.samples = Eigen::Map<const Eigen::MatrixXd>(samples.data(), n, n_channels);
  const py::gil_scoped_release released;
  fit::RingdownOptions options;
  options.band = {low_hz, high_hz};
  const fit::RingdownResult result = fit::identify_ringdown(signal, options);
  if (!result.usable()) throw NumericalError(result.message);
  ResultHeader header;
  header.kind = "analysis";
  header.status = "ok";
  header.provenance = make_provenance("klangprobe.analyze", 1, {{"a4_hz", a4_hz}}, {});
  fit::AnalysisDocument document = fit::analysis_document(std::move(header), result, a4_hz);
  document.duration_s = signal.duration_s();
  document.n_channels = static_cast<int>(n_channels);
  return json_text(json_of(document));
}

/// A specimen of a fit.json after the default strike, peak -3 dB re full scale.
py::array_t<double> synth(const std::string& path, const std::string& specimen,
                          const std::map<std::string, double>& dims, double duration_s, double rate_hz) {
  checked("synth", "duration_s", duration_s, 0.001, 3600.0);
  checked("synth", "rate_hz", rate_hz, 1000.0, 768000.0);
  Eigen::VectorXd sound;
  bool is_damped = true;
  {
    const py::gil_scoped_release released;
    const fit::FittedBody body = fit::fitted_body(fit::read_fit_document(path), path, specimen, {dims, {}});
    is_damped = body.decay_per_s.has_value();
    instrument::ModalBank bank =
        instrument::struck_bank(body.model, is_damped ? *body.decay_per_s : fit::assumed_decay_per_s(body.model),
                                fit::default_strike(body.model));
    instrument::normalise(bank, instrument::kPeak, rate_hz, std::min(duration_s, instrument::kPeakWithinS));
    sound = instrument::bank_sound(bank, rate_hz, static_cast<Eigen::Index>(std::llround(duration_s * rate_hz)));
  }
  if (!is_damped && PyErr_WarnEx(PyExc_UserWarning, damping::assumed_damping_words(path).c_str(), 2) != 0)
    throw py::error_already_set();
  return py::array_t<double>(sound.size(), sound.data());
}

}  // namespace

PYBIND11_MODULE(_klangprobe, module) {
  module.doc() = "Commands of klang, and sounds as arrays; use the package klangprobe";
  static const py::exception<NumericalError> error(module, "Error", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& problem) {
      PyErr_SetString(PyExc_ValueError, problem.what());
    } catch (const NumericalError& problem) {
      PyErr_SetString(error.ptr(), problem.what());
    }
  });
  module.def("version", [] { return version(); });
  module.def("call", &call, py::arg("words"));
  module.def("options", &options, py::arg("command"));
  module.def("did_you_mean", &meant, py::arg("word"), py::arg("known"));
  module.def("analyze", &analyze, py::arg("samples"), py::arg("rate_hz"), py::arg("a4_hz"), py::arg("low_hz"),
             py::arg("high_hz"));
  module.def("synth", &synth, py::arg("path"), py::arg("specimen"), py::arg("dims"), py::arg("duration_s"),
             py::arg("rate_hz"));
}
