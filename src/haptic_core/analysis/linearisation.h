/// Linear forces and inertia of a settled world about where it lies: the certificate's (certificate.h).
#pragma once
#include <functional>
#include <vector>

#include "haptic_core/base/eigen.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {

/// Thrown where the caller does not want the certificate any more.
struct Stopped {};

/// The linearisation of one settled world. Bodies act on one another by contacts alone: everything is kept by tree, and by the trees
/// that a contact joins, so that a thousand bodies cost a thousand times one.
class Linearisation {
 public:
  using Matrix = Eigen::MatrixXd;  ///< of any size

  /// `goOn` is asked between two trees; throws Stopped where it says no.
  Linearisation(const World& world, const std::function<bool()>& goOn);

  bool moves(int tree) const { return moves_[tree]; }  ///< it has degrees of freedom, and no hand holds it

  /// A contact at rest.
  struct Contact {
    int a, b;                    ///< world link indices
    int tree_a, tree_b;          ///< their trees
    ContactVolume volume;        ///< of both bodies
    PairLaw law;                 ///< of the pair
    /// Twist of B against A at P, P's axes, by the degrees of A's tree and of B's: 6 × n. Where both are one tree, all is in the second.
    Matrix J_a, J_b;             ///< [m/rad, 1]
    Matrix6 stiffness, damping;          ///< of the patch, P's axes
    Matrix6 mobility = Matrix6::Zero();  ///< of both bodies, their masses shared among their contacts
    int parts = 1;                       ///< contacts that share the mass of the body which has most of them

    /// visit(tree, J) for those that move.
    template <class Visit>
    void eachTree(Visit&& visit) const {
      if (J_a.cols() > 0) visit(tree_a, J_a);
      if (J_b.cols() > 0) visit(tree_b, J_b);
    }
  };

  std::vector<Matrix> M;                      ///< by tree: inertia [kg, kg·m²]
  std::vector<Contact> contacts;              ///< in the order of the pairs
  std::vector<std::vector<int>> contacts_of;  ///< by tree: those that it moves in

  /// Stiffness of an island, symmetric. `first`: by tree, its first row.
  Matrix stiffness(const std::vector<int>& trees, const std::vector<int>& first, Eigen::Index rows) const;

 private:
  /// Force on the degrees of `tree` by those of another one.
  struct Block {
    int tree;
    Matrix K;
  };

  int treeOf(int shape) const { return model_.treeOf(shape); }
  Eigen::Index degrees(int tree) const { return moves_[tree] ? model_.trees[tree].model->nv() : 0; }

  /// A tree at its q, at rest, with its shapes.
  void place(int t, const double* q);
  void placeAll(const std::vector<double>& q);

  /// Calls `visit` with every pair that touches of those in `which`, its contact at rest, without friction's memory. The pairs of one body
  /// with another are all in it, or none.
  template <class Visit>
  void eachContact(const std::vector<int>& which, Visit&& visit);

  /// Normal forces of the tree's contacts and its weight, times a factor, into the first columns; without slip there is no friction.
  void addForces(int t, double factor, std::vector<Block>& on);

  void linearise(const std::function<bool()>& goOn);
  Block& blockOf(int column, int row);
  void shareMobility();
  void addContact(const ActivePair& pair, const ContactEvaluation& contact);
  void addJacobian(int link, const Pose& X_WP, double sign, Matrix& J);

  /// Where faces end exactly above one another, a shift to either side uncovers an edge: the force has a kink there
  /// (of the size N d/a, harmless under friction). The differences are taken beside it, each body aside by its own
  /// part of kAside steps, so that none straddles it.
  void addDifferences(double epsilon, const std::function<bool()>& goOn);

  /// Forces on the tree, and on those that it touches, by its degrees. `beside`: its q.
  void differ(int t, double epsilon, const double* beside);
  /// What turns a step of a degree into one of the body's ends: its size for a rotation, one for a translation.
  double reach(const ModelTree& tree, int degree) const;

  const Model& model_;
  const State& state_;
  PairStore<ActivePair> pairs_;  ///< the state's, whose caches advance
  Seams seams_;
  ContactWorkspace workspace_;
  std::vector<int> held_by_;
  std::vector<char> moves_;
  std::vector<LinkWork> work_;
  std::vector<Pose> X_WS_;
  std::vector<std::vector<int>> shapes_of_, pairs_of_;  ///< by tree
  std::vector<std::vector<Block>> K_;                   ///< by tree: its columns, its own block first
  Vector3 gravity_;
};

/// Rows of an island in its matrices.
struct Rows {
  std::vector<int> first;        ///< by tree of the world; −1: in another island
  Eigen::Index count = 0;        ///< of all

  /// Of these trees, in that order.
  Rows(const Linearisation& linear, const std::vector<int>& trees) : first(linear.M.size(), -1) {
    for (const int t : trees) first[t] = static_cast<int>(count), count += linear.M[t].rows();
  }
  /// A contact's, dense.
  Eigen::MatrixXd of(const Linearisation::Contact& c) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, count);
    c.eachTree([&](int t, const Eigen::MatrixXd& of_tree) { J.middleCols(first[t], of_tree.cols()) += of_tree; });
    return J;
  }
};

}  // namespace haptic
