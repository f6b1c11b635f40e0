#pragma once
#include <memory>
#include <vector>

#include "fit/iet/iet_document.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// Moduli of one specimen from the partials of each of its taps: its model is made once.
class IetMeter {
 public:
  /// @throws InputError: a body without first flexural and torsional modes among its lowest
  explicit IetMeter(const IetSpecimen& specimen);
  ~IetMeter();
  IetMeter(const IetMeter&) = delete;
  IetMeter& operator=(const IetMeter&) = delete;

  /// By closed forms and full model; no frequencies, and why in remark, where nothing decays.
  IetRow row(const std::vector<Partial>& partials) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace klang::fit
