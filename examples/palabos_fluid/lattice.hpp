#pragma once

#include <vector>

#include <Eigen/Core>

#define COARSE_GRID_PROCESSORS_3D_HH  // leaves out a part of Palabos 1.5 that does not compile as C++20
#include <palabos3D.h>
#include <palabos3D.hh>

template <class T>
using D3Q19 = plb::descriptors::D3Q19Descriptor<T>;
using Vector = plb::Array<double, 3>;
using Lattice = plb::MultiBlockLattice3D<double, D3Q19>;

inline Vector to_palabos(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

/// The nodes from `low` to `high`, both included.
inline plb::Box3D box_of(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const auto node = [](double number) { return static_cast<plb::plint>(number); };
  return {node(low[0]), node(high[0]), node(low[1]), node(high[1]), node(low[2]), node(high[2])};
}

/// A halfway bounce-back wall that moves.
///   f_i ← f_ī + 6 t_i c_i · u
class MovingWall final : public plb::BounceBack<double, D3Q19> {
 public:
  explicit MovingWall(const Eigen::Vector3d& velocity) : BounceBack(1.0), velocity_(velocity) {}
  [[nodiscard]] MovingWall* clone() const override { return new MovingWall(*this); }
  void collide(plb::Cell<double, D3Q19>& cell, plb::BlockStatistics& statistics) override {
    BounceBack::collide(cell, statistics);
    for (int i = 1; i < D3Q19<double>::q; ++i)
      for (int axis = 0; axis < 3; ++axis)
        cell[i] += 6 * D3Q19<double>::t[i] * D3Q19<double>::c[i][axis] * velocity_[axis];
  }

 private:
  Eigen::Vector3d velocity_;
};

/// Gives every cell the momentum that the immersed boundary left in a field (exact difference method).
///   f_i ← f_i + f_i^eq(ρ, j) − f_i^eq(ρ, Σ c f)
class GiveMomentum final : public plb::BoxProcessingFunctional3D_LT<double, D3Q19, double, 3> {
 public:
  void process(plb::Box3D box, plb::BlockLattice3D<double, D3Q19>& lattice,
               plb::TensorField3D<double, 3>& momentum) override {
    const plb::Dot3D shift = plb::computeRelativeDisplacement(lattice, momentum);
    for (plb::plint x = box.x0; x <= box.x1; ++x)
      for (plb::plint y = box.y0; y <= box.y1; ++y)
        for (plb::plint z = box.z0; z <= box.z1; ++z)
          give(lattice.get(x, y, z), momentum.get(x + shift.x, y + shift.y, z + shift.z));
  }
  [[nodiscard]] GiveMomentum* clone() const override { return new GiveMomentum(*this); }
  void getTypeOfModification(std::vector<plb::modif::ModifT>& modified) const override {
    modified = {plb::modif::staticVariables, plb::modif::nothing};
  }

 private:
  static void give(plb::Cell<double, D3Q19>& cell, const Vector& wanted) {
    double density = 0.0;
    Vector found;
    plb::momentTemplates<double, D3Q19>::get_rhoBar_j(cell, density, found);
    if (wanted == found) return;
    const auto equilibrium = [&](int i, const Vector& j) {
      return cell.getDynamics().computeEquilibrium(i, density, j, plb::normSqr(j));
    };
    for (int i = 0; i < D3Q19<double>::q; ++i) cell[i] += equilibrium(i, wanted) - equilibrium(i, found);
  }
};
