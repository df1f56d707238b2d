// A stand-in of our own; see chainable_controller_interface.hpp. That the one derives from the other is checked.
#pragma once
#include <type_traits>
#define PLUGINLIB_EXPORT_CLASS(derived, base) static_assert(std::is_base_of<base, derived>::value, "no such plugin");
