/// M + Σ JᵀCJ + Σ JᵀGJ of a part of an island (frozen_problem.h), in blocks by tree.
#pragma once
#include <vector>

#include "haptic_core/dynamics/block_cholesky.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/stepping/frozen_contact.h"
#include "haptic_core/stepping/island_parts.h"
#include "haptic_core/world/model.h"

namespace haptic {

/// Assembles it; BlockCholesky factors it.
class FrozenMatrix {
 public:
  FrozenMatrix(const Model& model, int join_capacity);  ///< set-up: room for every tree, and so many contacts and forces

  /// (in realtime) M of a tree from its links as they stand.
  void freeze(int tree, LinkWork* work) noexcept;
  /// M of a tree as it was frozen, nv × nv.
  const double* massOf(int tree) const { return masses_.data() + mass_offset_[tree]; }
  /// (in realtime) uᵀ M u of trees; `u` in the order of the state [J].
  double massNorm2(const int* trees, int count, const double* u) const noexcept;

  /// (in realtime) The rows are the part's trees from now on. `work`: their links at the reference; it stays the caller's.
  void select(const IslandPart& part, LinkWork* work) noexcept;
  /// Row of blocks of a link's tree; -1: the part does not move it.
  int rowOf(int link) const { return row_of_tree_[model_.links[link].articulation]; }
  int rowOrWorld(int link) const { return link >= 0 ? rowOf(link) : -1; }  ///< the same; link −1: W
  int sizeAt(int row) const { return size_[row]; }         ///< degrees of freedom of a row's tree

  /// (in realtime) All three sums, of a stage of length g; computes G of the part's contacts at their V. False: it does not fit.
  bool assemble(const IslandPart& part, LoadedVector<FrozenContact>& contacts, const LoadedVector<FrozenForce>& forces,
                double g) noexcept;
  BlockCholesky& blocks() { return blocks_; }              ///< as assembled, to be factored

 private:
  bool isFree(int link) const { return model_.trees[model_.links[link].articulation].model->isFreeBody(); }
  void addContact(FrozenContact& c) noexcept;
  void addForce(const FrozenForce& c, double g) noexcept;
  /// Where a contact or force acts: links, A −1 for W; points in W; axes of its G.
  struct Ends {
    int link[2];
    const Vector3* p_W[2];
    const Matrix3& R_WP;
  };
  void addLinks(const Ends& ends, const Matrix6& G_P) noexcept;
  void addFree(int row_a, int row_b, const Ends& ends, const Matrix6& G) noexcept;
  void treeJacobian(int link, const Matrix3& R_WP, const Vector3& p_W, double* J) noexcept;

  const Model& model_;
  LinkWork* work_ = nullptr;
  std::vector<int> trees_, size_;       ///< by row
  std::vector<int> row_of_tree_;        ///< by tree; -1: not of the part
  std::vector<double> masses_;          ///< M by tree, one block after the other
  std::vector<std::size_t> mass_offset_;
  LoadedVector<BlockCholesky::Edge> edges_;
  BlockCholesky blocks_;
  std::vector<double> jacobian_a_, jacobian_b_, weighted_, block_;
};

}  // namespace haptic
