// Puts readings and references through the plugin and prints what it commands, beside what the C alone gives.
#include <cmath>
#include <cstdio>

#include "short_it_controller.hpp"

int main()
{
  short_it::Controller controller;
  const rclcpp_lifecycle::State state{};
  const rclcpp::Time time{};
  using controller_interface::CallbackReturn;
  if (controller.on_init() != CallbackReturn::SUCCESS || controller.on_configure(state) != CallbackReturn::SUCCESS) {
    return 1;
  }
  const auto states = controller.state_interface_configuration().names;
  const auto commands = controller.command_interface_configuration().names;
  for (const auto & name : states) { std::printf("state %s\n", name.c_str()); }
  for (const auto & name : commands) { std::printf("command %s\n", name.c_str()); }
  controller.states().assign(states.size(), {0.0});
  controller.commands().assign(commands.size(), {0.0});
  auto references = controller.references();
  for (const auto & each : references) { std::printf("reference %s\n", each.name_.c_str()); }
  for (std::size_t i = 0; i < SHORT_IT_NV; ++i) { controller.states()[2 * SHORT_IT_NV + i].value = 1.0; }
  if (controller.on_activate(state) != CallbackReturn::SUCCESS) { return 1; }

  short_it_state alone;
  short_it_sample sample{};
  short_it_setpoint setpoint{};
  for (int i = 0; i < SHORT_IT_NV; ++i) { sample.tau[i] = 1; }
  short_it_init(short_it_parameters_exported(), &alone, &sample);
  short_it_real tau[SHORT_IT_NV];
  int unequal = 0, errors = 0;
  double largest = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double dt = k < 100 ? SHORT_IT_PERIOD : 1.0;  // later the loop is far too slow: a fault
    for (std::size_t i = 0; i < SHORT_IT_NV; ++i) {
      const double q = 0.01 * std::sin(0.03 * k + 0.5 * static_cast<double>(i));
      *references[i].value_ = q;
      setpoint.q[i] = q;
      controller.states()[i].value = 0.9 * q;
      sample.q[i] = 0.9 * q;
    }
    const auto result = controller.update_and_write_commands(time, rclcpp::Duration(dt));
    short_it_step(short_it_parameters_exported(), &alone, &sample, &setpoint, dt, tau);
    errors += result == controller_interface::return_type::ERROR;
    for (std::size_t i = 0; i < SHORT_IT_NV; ++i) {
      const double given = controller.commands()[i].value;
      unequal += given < tau[i] || given > tau[i];
      largest = std::fmax(largest, std::fabs(given - tau[i]));
      controller.states()[2 * SHORT_IT_NV + i].value = given;
      sample.tau[i] = tau[i];
    }
  }
  std::printf("largest %.17g\n", largest);
  std::printf("unequal %d\nerrors %d\n", unequal, errors);
  return 0;
}
