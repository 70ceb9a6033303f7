// Motion of a tree of bodies by Pinocchio's forward dynamics and adaptive integrators, ours and Boost's, all in C++.

#define BOOST_MPL_LIMIT_LIST_SIZE 30
#define BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS

#include <string>
#include <vector>

#include "dop853.h"

#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>

using namespace pinocchio;
namespace odeint = boost::numeric::odeint;

using State = std::vector<double>;
using Vector3 = Eigen::Map<const Eigen::Vector3d>;
using Matrix3 = Eigen::Map<const Eigen::Matrix3d>;

enum Kind { REVOLUTE, PRISMATIC, SPHERICAL, FREE };
enum Method { PAIR_853, EXTRAPOLATION, FEHLBERG, DOPRI };

struct Spring {
  int joint[2];
  Eigen::Vector3d point[2];
  double stiffness, damping, rest;
};

struct System {
  Model model;
  Data data;
  std::vector<int> kinds;
  std::vector<Spring> springs;
  Eigen::VectorXd q, v, tau;
  PINOCCHIO_ALIGNED_STD_VECTOR(Force) forces;
  long evaluations;
};

static int coordinates(int kind) {
  return kind == FREE ? 3 : 0;
}

// q and v of a state, quaternions of unit length
static void load(System &s, const State &x) {
  const int nq = s.model.nq;
  s.q = Eigen::Map<const Eigen::VectorXd>(x.data(), nq);
  s.v = Eigen::Map<const Eigen::VectorXd>(x.data() + nq, s.model.nv);

  for (size_t j = 1; j <= s.kinds.size(); j++) {
    if (s.kinds[j - 1] >= SPHERICAL) {
      s.q.segment<4>(s.model.idx_qs[j] + coordinates(s.kinds[j - 1])).normalize();
    }
  }
}

static void apply_springs(System &s) {
  for (auto &f : s.forces) {
    f.setZero();
  }

  for (const auto &spring : s.springs) {
    Eigen::Vector3d r[2], w[2];

    for (int side = 0; side < 2; side++) {
      const auto &M = s.data.oMi[spring.joint[side]];
      const auto &v = s.data.v[spring.joint[side]];
      r[side] = M.act(spring.point[side]);
      w[side] = M.rotation() * (v.linear() + v.angular().cross(spring.point[side]));
    }

    const Eigen::Vector3d d = r[1] - r[0];
    const double length = d.norm();
    const Eigen::Vector3d u = d / length;
    const double pull = spring.stiffness * (length - spring.rest) + spring.damping * u.dot(w[1] - w[0]);

    for (int side = 0; side < 2; side++) {
      const int joint = spring.joint[side];
      const Eigen::Vector3d f = s.data.oMi[joint].rotation().transpose() * u * (side == 0 ? pull : -pull);
      s.forces[joint].linear() += f;
      s.forces[joint].angular() += spring.point[side].cross(f);
    }
  }
}

static void rates(System &s, const State &x, State &dx) {
  const int nq = s.model.nq;
  load(s, x);

  if (s.springs.empty()) {
    aba(s.model, s.data, s.q, s.v, s.tau, Convention::WORLD);
  } else {
    forwardKinematics(s.model, s.data, s.q, s.v);
    apply_springs(s);
    aba(s.model, s.data, s.q, s.v, s.tau, s.forces, Convention::WORLD);
  }

  s.evaluations++;
  Eigen::Map<Eigen::VectorXd>(dx.data() + nq, s.model.nv) = s.data.ddq;

  for (size_t j = 1; j <= s.kinds.size(); j++) {
    const int kind = s.kinds[j - 1], iq = s.model.idx_qs[j], iv = s.model.idx_vs[j];

    if (kind < SPHERICAL) {
      dx[iq] = s.v[iv];
      continue;
    }

    const int shift = coordinates(kind);
    const Eigen::Quaterniond E(s.q.segment<4>(iq + shift));
    const Eigen::Vector3d w = s.v.segment<3>(iv + shift);
    const Eigen::Quaterniond rate = E * Eigen::Quaterniond(0, w[0] / 2, w[1] / 2, w[2] / 2);
    Eigen::Map<Eigen::Vector4d>(dx.data() + iq + shift) = rate.coeffs();

    if (kind == FREE) {
      Eigen::Map<Eigen::Vector3d>(dx.data() + iq) = E * s.v.segment<3>(iv);
    }
  }
}

// the same between plain arrays
static void plain_rates(void *system, const double *x, double *rate) {
  System &s = *static_cast<System *>(system);
  static thread_local State state, found;
  state.assign(x, x + s.model.nq + s.model.nv);
  found.resize(state.size());
  rates(s, state, found);
  std::copy(found.begin(), found.end(), rate);
}

extern "C" System *motion_new(const double *gravity) {
  System *s = new System();
  s->model.gravity.linear() = Eigen::Map<const Eigen::Vector3d>(gravity);
  return s;
}

extern "C" void motion_delete(System *s) {
  delete s;
}

// a body on a joint; its frame is the joint's, z along the joint's axis; matrices by columns
extern "C" void motion_add(System *s, int parent, int kind, const double *position, const double *rotation,
                           double mass, const double *com, const double *inertia) {
  const SE3 placement(Eigen::Matrix3d{Matrix3(rotation)}, Eigen::Vector3d{Vector3(position)});
  const std::string name = "joint" + std::to_string(s->model.njoints);
  JointIndex joint;

  if (kind == REVOLUTE) {
    joint = s->model.addJoint(parent, JointModelRZ(), placement, name);
  } else if (kind == PRISMATIC) {
    joint = s->model.addJoint(parent, JointModelPZ(), placement, name);
  } else if (kind == SPHERICAL) {
    joint = s->model.addJoint(parent, JointModelSpherical(), placement, name);
  } else {
    joint = s->model.addJoint(parent, JointModelFreeFlyer(), placement, name);
  }

  const Inertia body(mass, Eigen::Vector3d{Vector3(com)}, Eigen::Matrix3d{Matrix3(inertia)});
  s->model.appendBodyToJoint(joint, body, SE3::Identity());
  s->kinds.push_back(kind);
}

// between points (m, in joints' frames; joint 0 is the ground)
extern "C" void motion_spring(System *s, int i, const double *point_i, int j, const double *point_j,
                              double stiffness, double damping, double rest) {
  Spring spring;
  spring.joint[0] = i;
  spring.joint[1] = j;
  spring.point[0] = Eigen::Map<const Eigen::Vector3d>(point_i);
  spring.point[1] = Eigen::Map<const Eigen::Vector3d>(point_j);
  spring.stiffness = stiffness;
  spring.damping = damping;
  spring.rest = rest;
  s->springs.push_back(spring);
}

extern "C" void motion_ready(System *s, int *nq, int *nv) {
  s->data = Data(s->model);
  s->tau = Eigen::VectorXd::Zero(s->model.nv);
  s->forces.assign(s->model.njoints, Force::Zero());
  *nq = s->model.nq;
  *nv = s->model.nv;
}

template <class Stepper>
static void run(System &s, Stepper stepper, State &x, const double *times, int n, double *rows) {
  const auto f = [&s](const State &x, State &dx, double) { rates(s, x, dx); };
  double t = 0, h = 1e-3 * times[0];

  for (int k = 0; k < n; k++) {
    // the step survives from one time to the next; one that the end cut short says little about it
    while (t < times[k]) {
      const double left = times[k] - t;
      const bool cut = h >= left * (1 - 1e-9);
      double step = cut ? left : h;
      const auto result = stepper.try_step(f, x, t, step);

      if (result == odeint::success) {
        t = cut ? times[k] : t;
        h = cut && step < h ? h : step;
      } else {
        h = step;
      }
    }

    std::copy(x.begin(), x.end(), rows + k * x.size());
  }
}

// states (n, nq + nv) at the times; returns the number of evaluations, -1 for an error
extern "C" long motion_run(System *s, const double *x0, const double *times, int n, int method,
                           double tolerance, double *rows) {
  using namespace odeint;
  using Fehlberg = runge_kutta_fehlberg78<State>;
  using Dopri = runge_kutta_dopri5<State>;

  State x(x0, x0 + s->model.nq + s->model.nv);
  s->evaluations = 0;

  try {
    if (method == PAIR_853) {
      return dop853(plain_rates, s, x.size(), x.data(), times, n, tolerance, rows);
    } else if (method == EXTRAPOLATION) {
      run(*s, bulirsch_stoer<State>(tolerance, tolerance), x, times, n, rows);
    } else if (method == FEHLBERG) {
      run(*s, make_controlled(tolerance, tolerance, Fehlberg()), x, times, n, rows);
    } else {
      run(*s, make_controlled(tolerance, tolerance, Dopri()), x, times, n, rows);
    }
  } catch (const std::exception &) {
    return -1;
  }

  return s->evaluations;
}
