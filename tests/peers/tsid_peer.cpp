// TSID's side of the comparison on the same robots (robots.py), through its C++ interface.
//
//     tsid_peer URDF PROBLEM STATES
//
// PROBLEM is what robots.py takes from the controller's file: a name and numbers per line. STATES and the lines of
// standard input are those of wbqp_peer.rs. A tick is what a user of TSID writes: contacts and tasks switched as asked,
// references set, the problem computed and solved, accelerations and torques read. The state is converted to
// Pinocchio's conventions before the clock starts.

#include <chrono>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody/joint/joint-free-flyer.hpp>
#include <tsid/contacts/contact-6d.hpp>
#include <tsid/contacts/contact-point.hpp>
#include <tsid/formulations/inverse-dynamics-formulation-acc-force.hpp>
#include <tsid/math/utils.hpp>
#include <tsid/robots/robot-wrapper.hpp>
#include <tsid/solvers/solver-HQP-eiquadprog-fast.hpp>
#include <tsid/tasks/task-actuation-bounds.hpp>
#include <tsid/tasks/task-com-equality.hpp>
#include <tsid/tasks/task-joint-posture.hpp>
#include <tsid/tasks/task-se3-equality.hpp>
#include <tsid/trajectories/trajectory-base.hpp>

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using tsid::trajectories::TrajectorySample;

using Numbers = std::vector<double>;

struct Problem {
  std::map<std::string, Numbers> numbers;
  std::map<std::string, std::string> words;

  explicit Problem(const std::string& file) {
    std::ifstream in(file);
    std::string line, name, word;
    while (std::getline(in, line)) {
      std::istringstream rest(line);
      rest >> name;
      std::string all;
      Numbers values;
      while (rest >> word) {
        all = word;
        try {
          values.push_back(std::stod(word));
        } catch (const std::invalid_argument&) {
        }
      }
      numbers[name] = values;
      words[name] = all;
    }
  }
  const Numbers& of(const std::string& name) const {
    const auto found = numbers.find(name);
    if (found == numbers.end()) throw std::runtime_error("the problem has no " + name);
    return found->second;
  }
  double one(const std::string& name) const { return of(name).at(0); }
};

struct Follow {
  Vector3d value, rate, acceleration;
};

struct Tick {
  double time;
  VectorXd q, v;
  // World from base, to turn the answer's accelerations into world axes.
  Matrix3d rotation;
  Vector3d linear, angular;
  Follow com, base;
  Matrix3d base_rotation;
  std::vector<bool> on;
  std::vector<Follow> swing;
};

static std::vector<std::string> names(std::istream& in) {
  std::string line, word;
  std::getline(in, line);
  std::istringstream rest(line);
  rest >> word;
  std::vector<std::string> all;
  while (rest >> word) all.push_back(word);
  return all;
}

struct States {
  std::vector<std::string> joints, contacts;
  // In Pinocchio's order.
  VectorXd posture;
  std::vector<int> index_q, index_v;
  std::vector<Tick> ticks;

  States(const std::string& file, const pinocchio::Model& model) {
    std::ifstream in(file);
    joints = names(in);
    contacts = names(in);
    const auto values = names(in);
    posture.resize(model.nv - 6);
    for (size_t i = 0; i < joints.size(); ++i) {
      const auto id = model.getJointId(joints[i]);
      if (id >= model.joints.size()) throw std::runtime_error("no joint " + joints[i]);
      index_q.push_back(model.joints[id].idx_q());
      index_v.push_back(model.joints[id].idx_v());
      posture[index_v[i] - 6] = std::stod(values[i]);
    }
    std::string line;
    while (std::getline(in, line)) {
      std::istringstream rest(line);
      const auto number = [&rest] {
        std::string word;
        rest >> word;
        return std::stod(word);
      };
      const auto three = [&] {
        const double x = number(), y = number(), z = number();
        return Vector3d(x, y, z);
      };
      const auto rotation = [&] {
        const double x = number(), y = number(), z = number(), w = number();
        return Quaterniond(w, x, y, z);
      };
      Tick tick;
      tick.time = number();
      tick.q = pinocchio::neutral(model);
      tick.v = VectorXd::Zero(model.nv);
      tick.q.head<3>() = three();
      const Quaterniond R = rotation();
      tick.q.segment<4>(3) = R.coeffs();
      tick.rotation = R.toRotationMatrix();
      for (const int i : index_q) tick.q[i] = number();
      tick.linear = three();
      tick.angular = three();
      tick.v.head<3>() = tick.rotation.transpose() * tick.linear;
      tick.v.segment<3>(3) = tick.rotation.transpose() * tick.angular;
      for (const int i : index_v) tick.v[i] = number();
      tick.com.value = three();
      tick.com.rate = three();
      tick.com.acceleration = three();
      tick.base_rotation = rotation().toRotationMatrix();
      tick.base.rate = three();
      tick.base.acceleration = three();
      for (size_t i = 0; i < contacts.size(); ++i) {
        tick.on.push_back(number() != 0.0);
        Follow swing;
        swing.value = three();
        swing.rate = three();
        swing.acceleration = three();
        tick.swing.push_back(swing);
      }
      ticks.push_back(tick);
    }
  }
};

// A sample of a task of TSID's on poses.
static TrajectorySample pose(const Matrix3d& R, const Vector3d& p, const Vector3d& v, const Vector3d& w,
                             const Vector3d& a, const Vector3d& alpha) {
  TrajectorySample sample(12, 6);
  VectorXd value(12), rate(6), acceleration(6);
  value.head<3>() = p;
  value.tail<9>() = Eigen::Map<const VectorXd>(R.data(), 9);
  rate << v, w;
  acceleration << a, alpha;
  sample.setValue(value);
  sample.setDerivative(rate);
  sample.setSecondDerivative(acceleration);
  return sample;
}

// The robot's controller, at the beginning.
class Controller {
 public:
  Controller(const std::string& urdf, const Problem& problem, const States& states, tsid::robots::RobotWrapper& robot)
      : states_(states),
        robot_(robot),
        formulation_("peer", robot, false),
        com_("com", robot),
        base_("base", robot, problem.words.at("base.frame")),
        posture_("posture", robot),
        torques_("torques", robot),
        solver_("eiquadprog-fast") {
    const auto constant = [](int n, double x) { return VectorXd::Constant(n, x).eval(); };
    const int na = robot.na();
    com_.Kp(constant(3, problem.one("com.kp")));
    com_.Kd(constant(3, problem.one("com.kd")));
    formulation_.addMotionTask(com_, problem.one("com.weight"), 1);

    VectorXd turns(6);
    turns << 0, 0, 0, 1, 1, 1;
    base_.setMask(turns);
    base_.useLocalFrame(false);
    base_.Kp(constant(6, problem.one("base.kp")));
    base_.Kd(constant(6, problem.one("base.kd")));
    formulation_.addMotionTask(base_, problem.one("base.weight"), 1);

    posture_.Kp(constant(na, problem.one("posture.kp")));
    posture_.Kd(constant(na, problem.one("posture.kd")));
    formulation_.addMotionTask(posture_, problem.one("posture.weight"), 1);
    TrajectorySample rest(na, na);
    rest.setValue(states.posture);
    posture_.setReference(rest);

    VectorXd limit(na);
    for (size_t i = 0; i < states.joints.size(); ++i)
      limit[states.index_v[i] - 6] = problem.one("effort." + states.joints[i]);
    torques_.setBounds(-limit, limit);
    formulation_.addActuationTask(torques_, 1.0, 0);

    const Vector3d up(0, 0, 1);
    for (const auto& name : states.contacts) {
      const std::string key = "contact." + name + ".";
      const std::string frame = problem.words.at(key + "frame");
      const double friction = problem.one(key + "friction"), damping = problem.one(key + "damping");
      const double least = problem.one(key + "force_min"), most = problem.one(key + "force_max");
      const Numbers& weight = problem.of(key + "weight");
      if (problem.words.at(key + "kind") == "full") {
        const double x = problem.one(key + "half_length_x"), y = problem.one(key + "half_length_y");
        Eigen::Matrix<double, 3, Eigen::Dynamic> corners(3, 4);
        corners << -x, -x, x, x, -y, y, -y, y, 0, 0, 0, 0;
        using Sole = tsid::contacts::Contact6d;
        auto contact = std::make_unique<Sole>(name, robot, frame, corners, up, friction, least, most);
        contact->Kp(constant(6, 0.0));
        contact->Kd(constant(6, damping));
        VectorXd share(6);
        for (int i = 0; i < 6; ++i) share[i] = std::sqrt(weight.at(i));
        contact->setRegularizationTaskWeightVector(share);
        force_weight_.push_back(1.0);
        contacts_.push_back(std::move(contact));
      } else {
        auto contact = std::make_unique<tsid::contacts::ContactPoint>(name, robot, frame, up, friction, least, most);
        contact->useLocalFrame(false);
        contact->Kp(constant(3, 0.0));
        contact->Kd(constant(3, damping));
        const VectorXd share = constant(3, 1.0);
        contact->setRegularizationTaskWeightVector(share);
        force_weight_.push_back(weight.at(0));
        contacts_.push_back(std::move(contact));
      }
      on_.push_back(false);
      if (problem.numbers.count("swing." + name + ".weight")) {
        auto task = std::make_unique<tsid::tasks::TaskSE3Equality>("swing_" + name, robot, frame);
        VectorXd shifts(6);
        shifts << 1, 1, 1, 0, 0, 0;
        task->setMask(shifts);
        task->useLocalFrame(false);
        task->Kp(constant(6, problem.one("swing." + name + ".kp")));
        task->Kd(constant(6, problem.one("swing." + name + ".kd")));
        swing_.push_back(std::move(task));
        swing_weight_.push_back(problem.one("swing." + name + ".weight"));
      } else {
        swing_.push_back(nullptr);
        swing_weight_.push_back(0.0);
      }
      swings_.push_back(false);
    }
    const Tick& first = states.ticks.front();
    const pinocchio::SE3 here = pinocchio::SE3::Identity();
    for (size_t i = 0; i < contacts_.size(); ++i) {
      // No stiffness: where the foot belongs has no effect.
      if (auto* point = dynamic_cast<tsid::contacts::ContactPoint*>(contacts_[i].get())) point->setReference(here);
      if (auto* sole = dynamic_cast<tsid::contacts::Contact6d*>(contacts_[i].get())) sole->setReference(here);
    }
    switch_contacts(first);
    solver_.resize(formulation_.nVar(), formulation_.nEq(), formulation_.nIn());
  }

  // The tick as a user writes it.
  void tick(const Tick& now) {
    if (on_ != now.on) {
      switch_contacts(now);
      solver_.resize(formulation_.nVar(), formulation_.nEq(), formulation_.nIn());
    }
    com_reference_.setValue(now.com.value);
    com_reference_.setDerivative(now.com.rate);
    com_reference_.setSecondDerivative(now.com.acceleration);
    com_.setReference(com_reference_);
    base_reference_ = pose(now.base_rotation, Vector3d::Zero(), Vector3d::Zero(), now.base.rate, Vector3d::Zero(),
                           now.base.acceleration);
    base_.setReference(base_reference_);
    for (size_t i = 0; i < swing_.size(); ++i) {
      if (!swings_[i]) continue;
      swing_reference_ = pose(Matrix3d::Identity(), now.swing[i].value, now.swing[i].rate, Vector3d::Zero(),
                              now.swing[i].acceleration, Vector3d::Zero());
      swing_[i]->setReference(swing_reference_);
    }
    const auto& data = formulation_.computeProblemData(now.time, now.q, now.v);
    solution_ = &solver_.solve(data);
    acceleration_ = &formulation_.getAccelerations(*solution_);
    torque_ = &formulation_.getActuatorForces(*solution_);
  }

  bool optimal() const { return solution_->status == tsid::solvers::HQP_STATUS_OPTIMAL; }
  const VectorXd& acceleration() const { return *acceleration_; }
  const VectorXd& torque() const { return *torque_; }
  unsigned variables() const { return formulation_.nVar(); }
  unsigned equalities() const { return formulation_.nEq(); }
  unsigned inequalities() const { return formulation_.nIn(); }

 private:
  void switch_contacts(const Tick& now) {
    for (size_t i = 0; i < contacts_.size(); ++i) {
      if (now.on[i] && !on_[i]) {
        formulation_.addRigidContact(*contacts_[i], force_weight_[i]);
        if (swings_[i]) formulation_.removeTask(swing_[i]->name());
        swings_[i] = false;
      } else if (!now.on[i] && on_[i]) {
        formulation_.removeRigidContact(contacts_[i]->name());
        if (swing_[i]) {
          formulation_.addMotionTask(*swing_[i], swing_weight_[i], 1);
          swings_[i] = true;
        }
      }
      on_[i] = now.on[i];
    }
  }

  const States& states_;
  tsid::robots::RobotWrapper& robot_;
  tsid::InverseDynamicsFormulationAccForce formulation_;
  tsid::tasks::TaskComEquality com_;
  tsid::tasks::TaskSE3Equality base_;
  tsid::tasks::TaskJointPosture posture_;
  tsid::tasks::TaskActuationBounds torques_;
  tsid::solvers::SolverHQuadProgFast solver_;
  std::vector<std::unique_ptr<tsid::contacts::ContactBase>> contacts_;
  std::vector<std::unique_ptr<tsid::tasks::TaskSE3Equality>> swing_;
  std::vector<double> force_weight_, swing_weight_;
  std::vector<bool> on_, swings_;
  TrajectorySample com_reference_{3, 3}, base_reference_{12, 6}, swing_reference_{12, 6};
  const tsid::solvers::HQPOutput* solution_ = nullptr;
  const VectorXd* acceleration_ = nullptr;
  const VectorXd* torque_ = nullptr;
};

struct Answer {
  bool optimal = false;
  VectorXd acceleration, torque;
  std::vector<long> times;
};

int main(int count, char** arguments) {
  if (count != 4) {
    std::cerr << "usage: tsid_peer URDF PROBLEM STATES\n";
    return 2;
  }
  const std::string urdf = arguments[1];
  tsid::robots::RobotWrapper robot(urdf, std::vector<std::string>(), pinocchio::JointModelFreeFlyer());
  const Problem problem(arguments[2]);
  const States states(arguments[3], robot.model());
  std::vector<Answer> answers(states.ticks.size());
  auto controller = std::make_unique<Controller>(urdf, problem, states, robot);
  unsigned variables = 0, equalities = 0, inequalities = 0;

  std::string line, asked;
  while (std::getline(std::cin, line)) {
    std::istringstream rest(line);
    rest >> asked;
    if (asked == "start") {
      controller = std::make_unique<Controller>(urdf, problem, states, robot);
    } else if (asked == "run") {
      size_t from, to;
      rest >> from >> to;
      for (size_t i = from; i < std::min(to, states.ticks.size()); ++i) {
        const auto start = std::chrono::steady_clock::now();
        controller->tick(states.ticks[i]);
        const auto spent = std::chrono::steady_clock::now() - start;
        answers[i].times.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count());
        answers[i].optimal = controller->optimal();
        answers[i].acceleration = controller->acceleration();
        answers[i].torque = controller->torque();
      }
      variables = std::max(variables, controller->variables());
      equalities = std::max(equalities, controller->equalities());
      inequalities = std::max(inequalities, controller->inequalities());
    } else if (asked == "write") {
      std::string file;
      rest >> file;
      std::ofstream out(file);
      out.precision(17);
      for (size_t i = 0; i < answers.size(); ++i) {
        const Answer& answer = answers[i];
        const Tick& tick = states.ticks[i];
        // From the spatial acceleration in body axes to the classical one of the base's origin in world axes.
        const Vector3d w = tick.v.segment<3>(3), v = tick.v.head<3>();
        const Vector3d a = tick.rotation * (answer.acceleration.head<3>() + w.cross(v));
        const Vector3d alpha = tick.rotation * answer.acceleration.segment<3>(3);
        out << answer.optimal << ' ' << a.transpose() << ' ' << alpha.transpose();
        for (const int j : states.index_v) out << ' ' << answer.acceleration[j];
        for (const int j : states.index_v) out << ' ' << answer.torque[j - 6];
        out << " |";
        for (const long time : answer.times) out << ' ' << time;
        out << '\n';
      }
    }
    std::cout << "done " << variables << ' ' << equalities << ' ' << inequalities << std::endl;
  }
}
