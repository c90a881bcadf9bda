// Which time steps a wall bears.
#pragma once

#include <string>

#include "dem_templates/plugin/wall/wall_body.hpp"

namespace granary::dem {

/// Time of a Hertzian impact without damping [s]:   2.94 d / v,   d = (15/16 m v^2 / (E* sqrt R))^(2/5)
/// the overlap at which the spring has taken up m v^2 / 2. Source: K. L. Johnson, Contact Mechanics (1985), 11.4.
double hertz_contact_time(double effective_young, double radius, double mass, double speed);

/// What is wrong with a time step for a body, a line each that says what to do; nothing if it is fine.
///
/// A blade that goes at most half a radius a step is seen before it reaches a centre. A contact of fewer than eight
/// steps gains energy.
/// smallest_radius: of the particles [m]; shortest_contact: of any with the body, at the speeds there are [s].
std::string time_step_problems(const WallBody& body, double smallest_radius, double shortest_contact, double time_step);

}  // namespace granary::dem
