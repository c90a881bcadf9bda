#include "pbm_solver/time/additive_method.hpp"

namespace granary::pbm {

AdditiveMethod explicit_method() {
  constexpr double sixth = 1.0 / 6.0;
  AdditiveMethod m;
  m.e = {{{}, {0.5}, {0.5, 0.5}, {sixth, sixth, sixth}, {sixth, sixth, sixth, 0.5}}};
  m.error_e = {-1.0 / 12.0, -1.0 / 12.0, -1.0 / 12.0, 0.25};
  return m;
}

AdditiveMethod implicit_explicit_method() {
  AdditiveMethod m;
  m.gamma = 0.25;
  m.e = {{{},
          {0.25},
          {-1.0 / 36.0, 25.0 / 36.0},
          {0.375, -0.125, 0.25},
          {9.0 / 22.0, -28.0 / 55.0, 51.0 / 110.0, 7.0 / 11.0}}};
  m.b = {{{}, {}, {0.0, 5.0 / 12.0}, {0.0, 0.425, -0.175}, {0.0, 0.4, -0.15, 0.5}}};
  // Less y + h (E(Y_3) + B Y_3), the midpoint rule; the last stage's own part of B has the weight gamma.
  m.error_e = {9.0 / 22.0, -28.0 / 55.0, 51.0 / 110.0, 7.0 / 11.0 - 1.0};
  m.error_b = {0.0, 0.4, -0.15, 0.5 - 1.0, 0.25};
  return m;
}

}  // namespace granary::pbm
