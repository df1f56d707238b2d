// A stand-in of our own; see chainable_controller_interface.hpp.
#pragma once
#include <string>

namespace hardware_interface
{
struct CommandInterface
{
  CommandInterface(const std::string & prefix, const std::string & name, double * value)
  : name_(prefix + "/" + name), value_(value) {}
  std::string name_;
  double * value_;
};
struct LoanedStateInterface
{
  double value;
  double get_value() const { return value; }
};
struct LoanedCommandInterface
{
  double value;
  [[nodiscard]] bool set_value(double given) { value = given; return true; }
};
}  // namespace hardware_interface
