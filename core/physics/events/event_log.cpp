#include "core/physics/events/event_log.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::events {
namespace {

std::string row_name(std::string_view table, std::size_t row) {
  return std::string(table) + "[" + std::to_string(row) + "]";
}

void check_reference(std::string_view table, std::size_t row, std::string_view what, int index, std::size_t n_rows) {
  if (index < static_cast<int>(n_rows)) return;
  throw InputError(row_name(table, row), "names a row of " + std::string(what) + " that is not there",
                   std::to_string(index), "below " + std::to_string(n_rows));
}

// Each owner's times rise in the order of the rows.
template <class Rows, class OwnerOf>
void check_rising(std::string_view table, const Rows& rows, OwnerOf owner_of) {
  std::unordered_map<int, double> last;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto [entry, is_first] = last.try_emplace(owner_of(rows[i]), rows[i].time_s);
    if (!is_first && !(entry->second < rows[i].time_s)) {
      throw InputError(row_name(table, i), "time_s does not rise", to_text(rows[i].time_s),
                       "more than " + to_text(entry->second));
    }
    entry->second = rows[i].time_s;
  }
}

void check_fractures(const EventLog& log) {
  std::vector<int> n_pieces(log.bodies.size(), 0);
  for (const Body& body : log.bodies) {
    if (body.parent >= 0) ++n_pieces[static_cast<std::size_t>(body.parent)];
  }
  std::vector<bool> broken(log.bodies.size(), false);
  for (std::size_t i = 0; i < log.fractures.size(); ++i) {
    const auto body = static_cast<std::size_t>(log.fractures[i].body);
    if (n_pieces[body] == 0) throw InputError(row_name("fractures", i), "the body has no pieces", std::to_string(body));
    if (broken[body]) throw InputError(row_name("fractures", i), "the body has broken already", std::to_string(body));
    broken[body] = true;
  }
}

}  // namespace

void EventLog::sort() {
  const auto by_time = [](const auto& a, const auto& b) { return a.time_s < b.time_s; };
  std::stable_sort(impulses.begin(), impulses.end(), by_time);
  std::stable_sort(fractures.begin(), fractures.end(), by_time);
  std::stable_sort(poses.begin(), poses.end(), [](const Pose& a, const Pose& b) {
    return a.body != b.body ? a.body < b.body : a.time_s < b.time_s;
  });
  std::stable_sort(bubble_points.begin(), bubble_points.end(), [](const BubblePoint& a, const BubblePoint& b) {
    return a.bubble != b.bubble ? a.bubble < b.bubble : a.time_s < b.time_s;
  });
}

void EventLog::validate() const {
  describe_tables(*this, [](std::string_view table, std::string_view, const auto& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::vector<Violation> violations;
      std::decay_t<decltype(rows[i])>::describe(rows[i], FieldCheck(violations));
      if (!violations.empty()) throw_violations(row_name(table, i), violations);
    }
  });
  for (std::size_t i = 0; i < bodies.size(); ++i) check_reference("bodies", i, "bodies before it", bodies[i].parent, i);
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    check_reference("impulses", i, "bodies", impulses[i].body, bodies.size());
    check_reference("impulses", i, "bodies", impulses[i].other, bodies.size());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    check_reference("poses", i, "bodies", poses[i].body, bodies.size());
    const double length = poses[i].orientation_wxyz.norm();
    if (!(std::abs(length - 1.0) <= 1e-6))
      throw InputError(row_name("poses", i), "orientation_wxyz is no unit quaternion", to_text(length), "length 1");
  }
  for (std::size_t i = 0; i < fractures.size(); ++i)
    check_reference("fractures", i, "bodies", fractures[i].body, bodies.size());
  for (std::size_t i = 0; i < bubble_points.size(); ++i)
    check_reference("bubble_points", i, "bubbles", bubble_points[i].bubble, bubbles.size());
  check_rising("poses", poses, [](const Pose& pose) { return pose.body; });
  check_rising("bubble_points", bubble_points, [](const BubblePoint& point) { return point.bubble; });
  check_fractures(*this);
}

Motion EventLog::motion_of(int body) const {
  std::vector<Pose> own;
  std::copy_if(poses.begin(), poses.end(), std::back_inserter(own),
               [&](const Pose& pose) { return pose.body == body; });
  return Motion(std::move(own));
}

std::vector<int> EventLog::pieces_of(int body) const {
  std::vector<int> pieces;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].parent == body) pieces.push_back(static_cast<int>(i));
  }
  return pieces;
}

std::optional<double> EventLog::broken_s(int body) const {
  for (const FractureEvent& event : fractures)
    if (event.body == body) return event.time_s;
  return {};
}

std::vector<std::vector<BubblePoint>> EventLog::bubble_paths() const {
  std::vector<std::vector<BubblePoint>> paths(bubbles.size());
  for (const BubblePoint& point : bubble_points) paths[static_cast<std::size_t>(point.bubble)].push_back(point);
  return paths;
}

std::string event_log_markdown() {
  std::string text;
  const EventLog empty;
  EventLog::describe_tables(empty, [&](std::string_view table, std::string_view meaning, const auto& rows) {
    using Row = typename std::decay_t<decltype(rows)>::value_type;
    text += "## " + std::string(table) + ": " + std::string(meaning) + "\n\n";
    text += field_rows_markdown(field_rows<Row>(), true) + "\n";
  });
  return text;
}

}  // namespace klang::events
