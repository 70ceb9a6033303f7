// A loop around Pinocchio's forward dynamics, so that no call from Python counts.

#define BOOST_MPL_LIMIT_LIST_SIZE 30
#define BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS

#include <string>

#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>

using namespace pinocchio;

struct Mechanism {
  Model model;
  Data data;
  Eigen::VectorXd q, v, tau;
};

extern "C" Mechanism *mechanism_new() {
  return new Mechanism();
}

extern "C" void mechanism_delete(Mechanism *s) {
  delete s;
}

// a body on a revolute joint about x, y or z (axis 0, 1, 2); matrices are symmetric or by columns
extern "C" void mechanism_add(Mechanism *s, int parent, int axis, const double *position,
                              const double *rotation, double mass, const double *com,
                              const double *inertia) {
  using Vector = Eigen::Map<const Eigen::Vector3d>;
  using Matrix = Eigen::Map<const Eigen::Matrix3d>;

  const SE3 placement(Eigen::Matrix3d{Matrix(rotation)}, Eigen::Vector3d{Vector(position)});
  const std::string name = "joint" + std::to_string(s->model.njoints);
  JointIndex joint;

  if (axis == 0) {
    joint = s->model.addJoint(parent + 1, JointModelRX(), placement, name);
  } else if (axis == 1) {
    joint = s->model.addJoint(parent + 1, JointModelRY(), placement, name);
  } else {
    joint = s->model.addJoint(parent + 1, JointModelRZ(), placement, name);
  }

  const Inertia body(mass, Eigen::Vector3d{Vector(com)}, Eigen::Matrix3d{Matrix(inertia)});
  s->model.appendBodyToJoint(joint, body, SE3::Identity());
}

extern "C" void mechanism_set(Mechanism *s, const double *gravity, const double *q, const double *v,
                              const double *tau) {
  s->model.gravity.linear() = Eigen::Map<const Eigen::Vector3d>(gravity);
  s->data = Data(s->model);
  s->q = Eigen::Map<const Eigen::VectorXd>(q, s->model.nq);
  s->v = Eigen::Map<const Eigen::VectorXd>(v, s->model.nv);
  s->tau = Eigen::Map<const Eigen::VectorXd>(tau, s->model.nv);
}

extern "C" void mechanism_loop(Mechanism *s, long n) {
  for (long k = 0; k < n; k++) {
    aba(s->model, s->data, s->q, s->v, s->tau, Convention::WORLD);
  }
}

extern "C" void mechanism_accelerations(Mechanism *s, double *vdot) {
  Eigen::Map<Eigen::VectorXd>(vdot, s->model.nv) = s->data.ddq;
}
