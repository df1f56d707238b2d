// A stand-in of our own; see chainable_controller_interface.hpp.
#pragma once
namespace rclcpp
{
class Time {};
}
