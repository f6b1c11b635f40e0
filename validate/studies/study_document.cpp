#include "validate/studies/study_document.hpp"

#include <cmath>

#include "core/foundation/config/fields_csv.hpp"

namespace klang::validate {
namespace {

LevelRecord level_record(const Series& series, std::size_t i) {
  const Level& level = series.levels[i];
  LevelRecord record{level.h_m,
                     level.n,
                     level.error,
                     level.value,
                     series.order.pairwise[i],
                     series.order.excluded[i],
                     level.n_unknowns,
                     level.wall_time_s,
                     {},
                     {},
                     {},
                     {},
                     {}};
  record.exact = level.exact;
  record.shape_error = level.shape_error;
  record.points = level.points;
  if (level.error_ci95) {
    record.error_low = (*level.error_ci95)[0];
    record.error_high = (*level.error_ci95)[1];
  }
  return record;
}

OrderRecord order_record(const Series& series) {
  OrderRecord record;
  for (std::size_t i = 0; i < series.levels.size(); ++i) record.levels.push_back(level_record(series, i));
  record.observed_order = series.order.observed_order;
  record.order_ci95 = series.order.ci95;
  if (series.kind == Convergence::kRoundOff) return record;
  record.expected_order = series.expected_order;
  if (std::isfinite(series.expected_order)) record.order_tolerance = series.order_tolerance;
  return record;
}

SeriesRecord series_record(const Series& series) {
  SeriesRecord record;
  record.id = series.id;
  record.title = series.title;
  record.reference = series.reference;
  record.step = series.step_words;
  record.error = series.error_words;
  record.kind = series.kind;
  record.order = order_record(series);
  record.higher_is_fine = series.higher_is_fine;
  record.error_tolerance = series.error_tolerance;
  record.error_floor = series.error_floor;
  record.floor = series.floor_words;
  record.counts = series.counts;
  record.asymptotic = series.order.asymptotic;
  if (series.gci) {
    record.gci =
        GciRecord{series.gci->order,      series.gci->extrapolated,     series.exact_value,     series.gci->gci_fine,
                  series.gci->gci_coarse, series.gci->asymptotic_ratio, series.gci->oscillating};
  }
  record.passed = series.passed;
  record.verdict = series.verdict;
  return record;
}

template <class Field>
FieldRecord field_record(const Field& field, const char* extension) {
  return {field.name, field.title, field.caption, field.name + extension, {}, {}, {}};
}

FieldRecords field_records(const Fields& fields) {
  FieldRecords records;
  for (const SurfaceField& field : fields.surfaces) {
    records.surfaces.push_back(field_record(field, ".vtp"));
    records.surfaces.back().quantity = field.quantity;
  }
  for (const SliceField& field : fields.slices) {
    records.slices.push_back(field_record(field, ".vti"));
    records.slices.back().quantity = field.quantity;
    records.slices.back().decibels = field.decibels;
    records.slices.back().floor = field.floor;
  }
  for (const BalloonField& field : fields.balloons) records.balloons.push_back(field_record(field, ".vtp"));
  return records;
}

/// A level with the names that tell it from others.
struct LevelRow {
  std::string series;
  std::size_t level = 0;
  LevelRecord record;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"series", "its id"}, self.series);
    visit({"level", "from 0, coarse to fine"}, self.level);
    LevelRecord::describe(self.record, visit);
  }
};

}  // namespace

StudyDocument study_document(ResultHeader header, const Study& study) {
  StudyDocument document;
  document.header = std::move(header);
  document.study = study.name;
  document.title = study.title;
  document.question = study.question;
  document.passed = study.passed();
  for (const Series& series : study.series) document.series.push_back(series_record(series));
  if (!document.series.empty()) document.main = document.series.front().order;
  document.claims = all_claims(study);
  document.fields = field_records(study.fields);
  return document;
}

std::string levels_csv(const Study& study) {
  std::vector<LevelRow> rows;
  for (const Series& series : study.series) {
    for (std::size_t i = 0; i < series.levels.size(); ++i) rows.push_back({series.id, i, level_record(series, i)});
  }
  return csv_table(rows, {"wall_time_s"});
}

}  // namespace klang::validate
