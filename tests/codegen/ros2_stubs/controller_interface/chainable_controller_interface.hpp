// A stand-in of our own, with the signatures that ros2_control documents for Jazzy; just enough to compile against.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace controller_interface
{
enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };
enum class interface_configuration_type : std::uint8_t { ALL = 0, INDIVIDUAL = 1, NONE = 2 };
enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };
struct InterfaceConfiguration
{
  interface_configuration_type type;
  std::vector<std::string> names = {};
};

struct Parameter
{
  std::vector<std::string> value;
  std::vector<std::string> as_string_array() const { return value; }
};
struct Node
{
  std::map<std::string, std::vector<std::string>> parameters;
  Parameter get_parameter(const std::string & name) const { return {parameters.at(name)}; }
  const char * get_name() const { return "stub"; }
};

class ChainableControllerInterface
{
public:
  virtual ~ChainableControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  std::shared_ptr<Node> get_node() const { return node_; }
  template<typename T>
  T auto_declare(const std::string & name, const T & value) { node_->parameters[name] = value; return value; }

  // For tests: in ros2_control the manager does this.
  std::vector<hardware_interface::LoanedCommandInterface> & commands() { return command_interfaces_; }
  std::vector<hardware_interface::LoanedStateInterface> & states() { return state_interfaces_; }
  std::vector<hardware_interface::CommandInterface> references() { return on_export_reference_interfaces(); }

protected:
  virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() { return {}; }
  virtual bool on_set_chained_mode(bool) { return true; }
  virtual return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  std::vector<double> reference_interfaces_;
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

private:
  std::shared_ptr<Node> node_ = std::make_shared<Node>();
};
}  // namespace controller_interface
