#include "tests/reports/fixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/modes_document.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "fit/run/fit_document.hpp"

namespace klang::reports::fixture {
namespace {

using nlohmann::json;

constexpr double kAlpha = 2.0e-8, kBeta = 1.1;  // Rayleigh
constexpr double kOuter = 0.0125, kWall = 0.001;
const std::array<const char*, 6> kNames = {"D3", "E3", "G3", "A3", "B3", "D4"};
const std::array<double, 6> kLengths = {0.505, 0.476, 0.436, 0.413, 0.390, 0.353};
// beta L of a free-free beam.
const std::array<double, 6> kBetaL = {4.730040744862704,  7.853204624095838, 10.995607838001671,
                                      14.137165491257464, 17.27875965739948, 20.42035224562606};

double decay(double frequency_hz) {
  const double omega = 2 * kPi * frequency_hz;
  return 0.5 * (kAlpha * omega * omega + kBeta);
}

struct TubeMode {
  double frequency_hz;
  char kind;  // 'b' bending in x, 'c' bending in y, 't' torsion
  int order;
};

/// Bending by Euler and Bernoulli with a correction that meets the reference tubes to 0.3 %, torsion by c_t n
/// / 2L.
std::vector<TubeMode> tube_modes(double length_m) {
  const double inner = kOuter - kWall, gyration = 0.5 * std::sqrt(kOuter * kOuter + inner * inner);
  const double bar_speed = std::sqrt(68.35e9 / 2700), shear_speed = std::sqrt(25.7e9 / 2700);
  std::vector<TubeMode> modes;
  for (std::size_t n = 0; n < kBetaL.size(); ++n) {
    const double k = kBetaL[n] / length_m;
    const double f = k * k * gyration * bar_speed / (2 * kPi) / (1 + 2.33 * k * gyration * k * gyration);
    modes.push_back({f, 'b', static_cast<int>(n)});
    modes.push_back({f * 1.000002, 'c', static_cast<int>(n)});
  }
  for (int n = 1; n <= 3; ++n) modes.push_back({n * shear_speed / (2 * length_m), 't', n});
  std::sort(modes.begin(), modes.end(),
            [](const TubeMode& a, const TubeMode& b) { return a.frequency_hz < b.frequency_hz; });
  return modes;
}

/// Deflection of a free-free beam and its slope, z from -L/2 to L/2.
std::array<double, 2> beam_shape(int order, double z, double length) {
  const double b = kBetaL[static_cast<std::size_t>(order)], x = (z / length + 0.5) * b;
  const double sigma = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
  return {std::cosh(x) + std::cos(x) - sigma * (std::sinh(x) + std::sin(x)),
          (std::sinh(x) - std::sin(x) - sigma * (std::cosh(x) + std::cos(x))) * b / length};
}

template <class Rows>
std::string data_array(const std::string& name, const char* type, int components, const Rows& write) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(9);
  out << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" NumberOfComponents=\"" << components
      << "\" format=\"ascii\">\n";
  write(out);
  out << "\n</DataArray>\n";
  return out.str();
}

void write_tube_vtu(const std::filesystem::path& path, double length_m, const std::vector<TubeMode>& modes) {
  mesh::ShapeSpec spec{"tube", {{"length_m", length_m}, {"outer_radius_m", kOuter}, {"wall_m", kWall}}, {}};
  mesh::ShapeDivisions divisions;
  divisions.counts = {24, 12, 1};
  const mesh::TetMesh mesh = mesh::mesh_shape(spec, divisions, 2);
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n";
  std::ostringstream frequencies;
  frequencies.precision(17);
  for (const TubeMode& mode : modes) frequencies << mode.frequency_hz << ' ';
  xml += "<DataArray type=\"Float64\" Name=\"frequencies_hz\" NumberOfTuples=\"" + std::to_string(modes.size()) +
         "\" format=\"ascii\">" + frequencies.str() + "</DataArray>\n</FieldData>\n";
  xml += "<Piece NumberOfPoints=\"" + std::to_string(mesh.n_nodes()) + "\" NumberOfCells=\"" +
         std::to_string(mesh.n_elements()) + "\">\n<PointData>\n";
  for (std::size_t m = 0; m < modes.size(); ++m) {
    std::string number = std::to_string(m);
    number.insert(0, 4 - number.size(), '0');
    xml += data_array("mode_" + number, "Float32", 3, [&](std::ostream& out) {
      for (int i = 0; i < mesh.n_nodes(); ++i) {
        const double x = mesh.nodes_m(i, 0), y = mesh.nodes_m(i, 1), z = mesh.nodes_m(i, 2);
        const auto [w, slope] = beam_shape(modes[m].order % 6, z, length_m);
        const double twist = std::cos(kPi * modes[m].order * (z / length_m + 0.5)) / kOuter;
        if (modes[m].kind == 'b') out << w << " 0 " << -x * slope << '\n';
        if (modes[m].kind == 'c') out << "0 " << w << ' ' << -y * slope << '\n';
        if (modes[m].kind == 't') out << -y * twist << ' ' << x * twist << " 0\n";
      }
    });
  }
  xml += "</PointData>\n<Points>\n" +
         data_array("points", "Float64", 3,
                    [&](std::ostream& out) {
                      for (int i = 0; i < mesh.n_nodes(); ++i)
                        out << mesh.nodes_m(i, 0) << ' ' << mesh.nodes_m(i, 1) << ' ' << mesh.nodes_m(i, 2) << '\n';
                    }) +
         "</Points>\n<Cells>\n";
  xml += data_array("connectivity", "Int64", 1, [&](std::ostream& out) {
    for (int e = 0; e < mesh.n_elements(); ++e) {
      for (int k = 0; k < 10; ++k) out << mesh.elements(e, k) << ' ';
    }
  });
  xml += data_array("offsets", "Int64", 1, [&](std::ostream& out) {
    for (int e = 0; e < mesh.n_elements(); ++e) out << 10 * (e + 1) << ' ';
  });
  xml += data_array("types", "UInt8", 1, [&](std::ostream& out) {
    for (int e = 0; e < mesh.n_elements(); ++e) out << "24 ";
  });
  write_file(path, xml + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

struct Tone {
  double frequency_hz, decay_per_s, amplitude, phase_rad;
};

audio::Signal ringing(const std::vector<Tone>& tones, double rate, double seconds, double noise, std::uint64_t seed) {
  audio::Signal signal;
  signal.sample_rate_hz = rate;
  const auto n = static_cast<Eigen::Index>(seconds * rate);
  signal.samples = Eigen::MatrixXd::Zero(n, 1);
  const auto start = static_cast<Eigen::Index>(0.1 * rate);
  RandomStream random(seed, 1);
  for (Eigen::Index i = 0; noise > 0 && i < n; ++i) signal.samples(i, 0) = noise * random.normal();
  for (const Tone& tone : tones) {
    for (Eigen::Index i = start; i < n; ++i) {
      const double t = static_cast<double>(i - start) / rate;
      signal.samples(i, 0) +=
          tone.amplitude * std::exp(-tone.decay_per_s * t) * std::cos(2 * kPi * tone.frequency_hz * t + tone.phase_rad);
    }
  }
  return signal;
}

/// Found, with its 95 % interval.
fit::FitParameter found(const char* name, double value, double std, double start, bool derived = false) {
  return {
      name,  value, std,    std::array{value - 1.96 * std, value + 1.96 * std}, true, "", fit::Verdict::kTrusted, start,
      false, "",    derived};
}

fit::FitParameter not_found(const char* name, double value, const char* why, double start) {
  return {name, value, {}, {}, false, why, fit::Verdict::kNotJudged, start, false, "", false};
}

fit::DampingRecord candidate(const char* model, std::vector<fit::FitParameter> parameters, double aicc, double weight,
                             double rms, double (*rate)(double)) {
  fit::DampingRecord record{model, std::move(parameters), aicc, weight, rms, {}};
  for (int i = 0; i <= 60; ++i) {
    record.curve.frequency_hz.push_back(400 * std::pow(45.0, i / 60.0));
    record.curve.decay_per_s.push_back(rate(record.curve.frequency_hz.back()));
  }
  return record;
}

ResultHeader header(const char* kind, const char* status, const char* command,
                    std::map<std::string, double> wall_time_s) {
  ResultHeader header;
  header.kind = kind;
  header.status = status;
  header.provenance = {"0.1.0",
                       command,
                       1,
                       {R"({"gate_cents": 60.0, "robust": true})"},
                       {{"six-chimes.toml", 1630, std::string(64, 'a')}}};
  header.wall_time_s = std::move(wall_time_s);
  return header;
}

std::vector<fit::FitParameter> parameters_of_six_chimes() {
  return {not_found("lame_lambda_pa", 4.98e10,
                    "bending frequencies depend on Young's modulus alone: moving along constant E changes no "
                    "frequency by more than its error",
                    4.98e10),
          not_found("lame_mu_pa", 2.57e10,
                    "only the combination E = mu (3 lambda + 2 mu) / (lambda + mu) is determined", 2.7e10),
          found("rayleigh_stiffness_s", 2.003e-8, 3.1e-11, 1e-7), found("rayleigh_mass_per_s", 1.0952, 0.0113, 1.0),
          found("youngs_modulus_pa", 6.8404e10, 5.2e7, 7e10, true)};
}

fit::DampingRecords damping_of_six_chimes() {
  return {
      "rayleigh",
      {candidate(
           "rayleigh",
           {found("rayleigh_stiffness_s", 2.003e-8, 3.1e-11, 1e-7), found("rayleigh_mass_per_s", 1.0952, 0.0113, 1.0)},
           -151.3, 0.9985, 0.0213, [](double f) { return decay(f); }),
       candidate("zener",
                 {found("zener_strength", 0.0024, 1e-4, 0.001), found("zener_relaxation_time_s", 1.1e-6, 2e-7, 1e-6)},
                 -138.2, 0.0014, 0.041,
                 [](double f) { return 0.0012 * 2 * kPi * f * (f / 14000) / (1 + f * f / 196e6) + 0.4; }),
       candidate("stiffness_only", {found("rayleigh_stiffness_s", 2.2e-8, 4e-10, 1e-7)}, -60.1, 1e-20, 0.31,
                 [](double f) { return 1.1e-8 * 4 * kPi * kPi * f * f; }),
       candidate("loss_factor", {found("loss_factor", 7e-4, 1e-4, 1e-3)}, -12.4, 1e-30, 0.62,
                 [](double f) { return 7e-4 * kPi * f; }),
       candidate("mass_only", {found("rayleigh_mass_per_s", 9.1, 2.0, 1.0)}, 40.9, 1e-42, 0.91,
                 [](double) { return 4.55; })}};
}

/// What one tube adds to a fit, and how it sounds.
struct Tube {
  fit::SpecimenRecord record;
  std::vector<fit::MatchRecord> matches;
  std::vector<fit::PredictedRecord> predicted;
  std::vector<Tone> heard, modelled;
};

Tube make_tube(int number, const std::string& name, double length_m, RandomStream& random) {
  Tube tube;
  double sum_sq = 0, largest = 0;
  const double own_cents = 1.3 * random.normal();
  const std::vector<TubeMode> modes = tube_modes(length_m);
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const double f = modes[m].frequency_hz;
    const int index = static_cast<int>(m);
    tube.predicted.push_back({name, index, f, {}, decay(f)});
    if (modes[m].kind != 'b' || (number == 2 && modes[m].order == 4)) continue;
    const double deviation = own_cents + 0.8 * random.normal();
    const double measured = f * std::exp2(deviation / 1200), std_hz = 0.004 * std::pow(f / 600, 1.2);
    const double rate_std = 0.004 * decay(f) * (1 + f / 4000), rate = decay(f) + 1.1 * rate_std * random.normal();
    const double amplitude = 0.22 * std::pow(0.62, modes[m].order) * (0.7 + 0.6 * random.uniform());
    const double phase = random.uniform(-kPi, kPi);
    tube.heard.push_back({measured, rate, amplitude, phase});
    tube.modelled.push_back({f, decay(f), amplitude, phase});
    tube.record.partials.push_back({{measured, std_hz, rate, rate_std, amplitude, 0.001, phase, 0.01}, index});
    fit::MatchRecord match;
    match.specimen = name;
    match.mode_index = index;
    match.frequency_hz = measured;
    match.frequency_std_hz = std_hz;
    match.model_frequency_hz = f;
    match.deviation_cents = deviation;
    match.decay_per_s = rate;
    match.decay_std_per_s = rate_std;
    match.model_decay_per_s = decay(f);
    tube.matches.push_back(match);
    sum_sq += deviation * deviation;
    largest = std::max(largest, std::abs(deviation));
  }
  if (number == 1) {  // the stand's own sound
    tube.heard.push_back({2210.4, 14.0, 0.02, 0.3});
    tube.record.partials.push_back({{2210.4, 0.09, 14.0, 0.6, 0.02, 0.001, 0.3, 0.05}, {}});
  }
  tube.record.name = name;
  tube.record.shape.text =
      json{{"kind", "tube"}, {"length_m", length_m}, {"outer_radius_m", kOuter}, {"wall_m", kWall}}.dump();
  tube.record.mass_kg = 2700 * length_m * kPi * (kOuter * kOuter - (kOuter - kWall) * (kOuter - kWall));
  tube.record.n_nodes = 11664;
  tube.record.n_elements = 5760;
  tube.record.none_missing = true;
  tube.record.rms_deviation_cents = std::sqrt(sum_sq / static_cast<double>(tube.matches.size()));
  tube.record.max_deviation_cents = largest;
  tube.record.strikes_s = {0.1};
  tube.record.explained_energy = 0.9987;
  return tube;
}

}  // namespace

json write_fit(const std::filesystem::path& folder, const FitFixture& fixture) {
  std::filesystem::create_directories(folder);
  fit::FitDocument document;
  document.header = header("fit", "converged", "klang fit six-chimes.toml -o out", {{"modes", 11.2}, {"fit", 3.4}});
  document.name = "Six chimes";
  document.material_start.preset = "aluminium";
  document.material.density_kg_m3 = 2700.0;
  document.cost_initial = 5321.7;
  document.cost_final = 21.3;
  document.n_iterations = 9;
  document.parameters = parameters_of_six_chimes();
  document.correlation = {{"rayleigh_stiffness_s", "rayleigh_mass_per_s"}, {{1.0, -0.41}, {-0.41, 1.0}}};
  document.damping = damping_of_six_chimes();
  RandomStream random(20, 3);
  for (int s = 0; s < fixture.n_specimens; ++s) {
    const std::string name = s == 0  ? fixture.first_name
                             : s < 6 ? kNames[static_cast<std::size_t>(s)]
                                     : "T" + std::to_string(s);
    const std::string stem = "specimen" + std::to_string(s);
    const double length = s < 6 ? kLengths[static_cast<std::size_t>(s)] : 0.3 + 0.01 * (s % 17);
    Tube tube = make_tube(s, name, length, random);
    if (fixture.sounds) {
      tube.record.files.recording = "recording-" + stem + ".wav";
      tube.record.files.resynthesis = "resynthesis-" + stem + ".wav";
      write_sound(folder / *tube.record.files.recording,
                  ringing(tube.heard, fixture.sample_rate_hz, 3.0, 3e-4, 7 + static_cast<std::uint64_t>(s)));
      write_sound(folder / *tube.record.files.resynthesis, ringing(tube.modelled, fixture.sample_rate_hz, 3.0, 0, 0));
    }
    if (fixture.shapes) {
      tube.record.files.modes = "modes-" + stem + ".vtu";
      write_tube_vtu(folder / *tube.record.files.modes, length, tube_modes(length));
    }
    document.matches.insert(document.matches.end(), tube.matches.begin(), tube.matches.end());
    document.predicted.insert(document.predicted.end(), tube.predicted.begin(), tube.predicted.end());
    document.specimens.push_back(std::move(tube.record));
  }
  const json result = json_of(document);
  write_file(folder / "fit.json", json_text(result));
  return result;
}

json write_analysis(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  fit::AnalysisDocument document;
  document.header = header("analysis", "ok", "klang analyze glass.flac -o out", {{"total", 0.8}});
  document.header.warnings = {"mains hum at 50 Hz ignored"};
  std::vector<Tone> tones;
  RandomStream random(5, 9);
  for (int i = 0; i < 14; ++i) {
    const double f = 410 * std::pow(1.29, i) * (1 + 0.02 * random.normal()),
                 rate = 1.5 + 0.0016 * f * (0.7 + 0.6 * random.uniform());
    const double amplitude = 0.12 * std::pow(0.8, i) * (0.5 + random.uniform());
    tones.push_back({f, rate, amplitude, 0.1 * i});
    document.partials.push_back({f, 0.01 + 1e-5 * f, rate, 0.02 * rate, amplitude, 0.01 * amplitude, 0.1 * i, 0.02});
  }
  document.sample_rate_hz = 44100.0;
  document.duration_s = 2.5;
  document.n_channels = 2;
  document.strikes_s = {0.1};
  document.explained_energy = 0.9931;
  document.noise_rms = 4e-4;
  document.files = {"recording.wav", "resynthesis.wav"};
  write_sound(folder / "recording.wav", ringing(tones, 44100, 2.5, 4e-4, 11));
  write_sound(folder / "resynthesis.wav", ringing(tones, 44100, 2.5, 0, 0));
  const json result = json_of(document);
  write_file(folder / "analysis.json", json_text(result));
  return result;
}

json write_modes(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const std::vector<TubeMode> modes = tube_modes(0.2);
  write_tube_vtu(folder / "modes.vtu", 0.2, modes);
  modal::ModesDocument document;
  document.header = header("modes", "converged", "klang modes --shape tube --json modes.json", {{"total", 1.1}});
  for (std::size_t m = 0; m < modes.size(); ++m)
    document.modes.push_back({static_cast<int>(m), modes[m].frequency_hz, 3e-13, {}, {}});
  document.n_nodes = 2880;
  document.n_elements = 1440;
  document.element = "p2";
  document.n_rigid_modes = 6;
  document.none_missing = true;
  document.peak_memory_bytes = 81000000;
  document.shape.text = json{{"kind", "tube"}, {"length_m", 0.2}, {"outer_radius_m", kOuter}, {"wall_m", kWall}}.dump();
  document.files = modal::ModeFiles{"modes.vtu"};
  const json result = json_of(document);
  write_file(folder / "modes.json", json_text(result));
  return result;
}

}  // namespace klang::reports::fixture
