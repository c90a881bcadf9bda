#include "pbm_solver/time/additive_method.hpp"

namespace granary::pbm {

AdditiveMethod explicit_method() {
  constexpr double sixth = 1.0 / 6.0;
  AdditiveMethod m;
  m.e = {{{},
          {0.5},
          {0.5, 0.5},
          {sixth, sixth, sixth},
          {sixth, sixth, sixth, 0.5}}};
  m.error_e = {-1.0 / 12.0, -1.0 / 12.0, -1.0 / 12.0, 0.25};
  return m;
}

AdditiveMethod implicit_explicit_method() {
  AdditiveMethod m;
  m.gamma = 0.5;
  m.e = {{{},
          {0.5},
          {11.0 / 18.0, 1.0 / 18.0},
          {5.0 / 6.0, -5.0 / 6.0, 0.5},
          {0.25, 1.75, 0.75, -1.75}}};
  m.b = {{{},
          {},
          {0.0, 1.0 / 6.0},
          {0.0, -0.5, 0.5},
          {0.0, 1.5, -1.5, 0.5}}};
  // Less y + h (E(Y_1) + B Y_1), the midpoint rule; the last stage's own part of B has the weight gamma.
  m.error_e = {0.25, 0.75, 0.75, -1.75};
  m.error_b = {0.0, 0.5, -1.5, 0.5, 0.5};
  return m;
}

}  // namespace granary::pbm
