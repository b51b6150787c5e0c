!> Products of groups of many nodes in space: displacement gradients, internal forces and stiffness of the points of a
!> group (qsmpm_group_stiffness has the equations). They are small for a library of dense matrices, which copies both
!> factors and pads them. Here nodes are taken four at a time, a pair of four and four stays in registers over all
!> points, and only half of a symmetric stiffness is formed. The same lines are compiled for processors with AVX2 too
!> (qsmpm_wide_kernels_avx2).
module qsmpm_wide_kernels
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: width, first_of, second_of, find_tensors, add_forces, form_stiffness

  !> Nodes of a block.
  integer, parameter :: width = 4
  !> Components i and k of the pairs that are formed together: those with i = k, and the others in two threes, mirror
  !> images (pair, three).
  integer, parameter :: first_of(3, 3) = reshape([1, 2, 3, 1, 1, 2, 2, 3, 3], [3, 3])
  integer, parameter :: second_of(3, 3) = reshape([1, 2, 3, 2, 3, 3, 1, 1, 2], [3, 3])

contains

  include 'wide_kernels.inc'
end module qsmpm_wide_kernels
