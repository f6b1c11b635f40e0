#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>

#include "core/foundation/opencl/session.hpp"
#include "core/sound/transfer/transfer_evaluation.hpp"

namespace klang::acoustics {

using opencl::Precision;

/// p_i(x) of all modes at many listeners on an OpenCL device, in the passes of SB section 4: Hankel functions by recurrence, Y_m^m,
/// Y_n^m by recurrence, reduction. Kernels are compiled once a device and precision in the process. May be called from
/// several threads at once; calls on one object take turns.
class OpenClTransfer {
 public:
  /// @param choice  as chosen_device
  /// @throws InputError when no device fits the choice; opencl::Error when the device cannot do it
  OpenClTransfer(const TransferModel& model, const std::string& choice, Precision precision);
  ~OpenClTransfer();
  OpenClTransfer(const OpenClTransfer&) = delete;
  OpenClTransfer& operator=(const OpenClTransfer&) = delete;

  /// As TransferEvaluator::evaluate; 1e-12 (double) or 1e-5 (single) of it, relative to the largest |p| of the mode on a sphere.
  void evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m, Eigen::MatrixXcd& pressures_pa);
  const opencl::Device& device() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// On the processor (TransferEvaluator) or on a device. Without an OpenCL device, or where the device cannot do what is asked, it is the processor's, and
/// message() says why in one line.
class AnyTransferEvaluator {
 public:
  AnyTransferEvaluator(const TransferModel& model, const opencl::DeviceChoice& where);
  void evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m, Eigen::MatrixXcd& pressures_pa);
  const std::string& message() const { return message_; }          ///< empty: as asked
  const std::string& device_name() const { return device_name_; }  ///< "processor" or the device's name

 private:
  std::unique_ptr<TransferEvaluator> processor_;
  std::unique_ptr<OpenClTransfer> device_;
  std::string message_, device_name_ = "processor";
};

}  // namespace klang::acoustics
