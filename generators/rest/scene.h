#pragma once

#include "generators/made/scene.h"
#include "generators/rest/rest.h"

// What the rest sets are built of: the bodies and contacts of made sets, the contacts with the impulses that balance
// them. A weight stands for the impulse that it gives in one step. Units: m, kg, s.

namespace lcpbench::rest {

using made::Axes;
using made::kWorld;
using made::kZ;
using made::Triple;
using made::operator+;
using made::operator-;
using made::operator*;

double weight(double mass);     ///< of a step [N s]
double cube_edge(double mass);  ///< of a cube with 1000 kg/m^3

/// The friction of the contacts between two bodies.
struct Surface {
  int edges = 4;
  double mu = 1;     ///< the least mu of its contacts; with a margin below 1 the largest
  double turn = 0;   ///< from the first friction direction to the friction that the balance needs [turns]
  double slope = 0;  ///< friction per normal load that leaves the margin of the trial
};

class Scene : public made::Scene {
 public:
  Scene(const RestReading& reading, const TrialKey& key);

  bool can_rest() const { return margin_ >= 1; }
  const Axes& axes() const { return axes_; }  ///< horizontal ones, and z
  bool slides() const { return slides_; }     ///< what presses: sliders of one coordinate each, else free bodies
  /// The fewest contacts of a patch: three hold a free body whatever else holds it.
  int least() const { return slides_ ? 2 : 3; }
  /// From -1 to 1, and 0 in a regular scene: how far something lies from its usual place.
  double jitter() { return (is_regular_ ? 0 : 1) * uniform(-1, 1); }
  /// Of the body number `k`: all equal, each drawn, or light ones between heavy ones.
  double mass_of(int k);
  /// @param is_inner  inside a chain of bodies: mu is raised where the balance needs it
  Surface surface(bool is_inner = false);

  int body(double mass, const Triple& centre);
  /// What presses with `impulse` at `point`. A slider moves along `axis`: its guide carries all but the part of the
  /// impulse along it.
  int finger(double mass, const Triple& axis, const Triple& impulse, const Triple& point);
  /// `count` contacts at which `b` pushes `a`, in a plane around `centre`, each with a share of `impulse`, the mean of
  /// the shares at the centre. From the contact `least` on some may be open: with a positive offset and no load.
  void patch(int a, int b, int count, int least, const Surface& surface, const Triple& centre, const Triple& normal,
             const Triple& impulse, double radius);

 private:
  Axes axes_{};
  double margin_ = 1, even_mass_ = 1, odd_mass_ = 1, open_share_ = 0, unevenness_ = 1;
  bool slides_ = false;
  bool masses_are_drawn_ = false;
  bool mu_is_shared_ = true;  // by the contacts of a surface
  bool is_regular_ = false;   // even loads, symmetric places, friction along edges
  int edges_ = 0;             // 0: each surface has its own
  double mu_ = 0;             // alike
};

}  // namespace lcpbench::rest
