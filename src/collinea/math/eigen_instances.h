// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>

// Decompositions that many files use and that are dear to compile (one to six seconds each). With the precompiled
// header, which reads this list as declarations, they are compiled once, in eigen_instances.cc, which reads it again as
// definitions: hence no guard. A file that does not read it compiles its own, to the same bits.
#ifndef COLLINEA_EIGEN_INSTANCE
#define COLLINEA_EIGEN_INSTANCE extern template
#endif

namespace collinea::instances {
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
}  // namespace collinea::instances

namespace Eigen {

COLLINEA_EIGEN_INSTANCE LDLT<Matrix3d>& LDLT<Matrix3d>::compute(const EigenBase<Matrix3d>&);
COLLINEA_EIGEN_INSTANCE void LDLT<Matrix3d>::_solve_impl_transposed<true>(const Vector3d&, Vector3d&) const;
COLLINEA_EIGEN_INSTANCE LDLT<collinea::instances::Matrix6>& LDLT<collinea::instances::Matrix6>::compute(
    const EigenBase<collinea::instances::Matrix6>&);
COLLINEA_EIGEN_INSTANCE LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
COLLINEA_EIGEN_INSTANCE void LDLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;

COLLINEA_EIGEN_INSTANCE SelfAdjointEigenSolver<Matrix2d>& SelfAdjointEigenSolver<Matrix2d>::compute(
    const EigenBase<Matrix2d>&, int);
COLLINEA_EIGEN_INSTANCE SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(
    const EigenBase<Matrix3d>&, int);
COLLINEA_EIGEN_INSTANCE SelfAdjointEigenSolver<collinea::instances::Matrix7>&
SelfAdjointEigenSolver<collinea::instances::Matrix7>::compute(const EigenBase<collinea::instances::Matrix7>&, int);
COLLINEA_EIGEN_INSTANCE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);

COLLINEA_EIGEN_INSTANCE JacobiSVD<Matrix3d>& JacobiSVD<Matrix3d>::compute(const Matrix3d&, unsigned int);
COLLINEA_EIGEN_INSTANCE JacobiSVD<MatrixXd>& JacobiSVD<MatrixXd>::compute(const MatrixXd&, unsigned int);
// Quaterniond::FromTwoVectors, for opposite directions.
COLLINEA_EIGEN_INSTANCE JacobiSVD<collinea::instances::Matrix23>& JacobiSVD<collinea::instances::Matrix23>::compute(
    const collinea::instances::Matrix23&, unsigned int);

}  // namespace Eigen

#undef COLLINEA_EIGEN_INSTANCE
