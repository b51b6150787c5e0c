!> The products of qsmpm_wide_kernels, compiled for processors with AVX2 and FMA (CMakeLists.txt).
module qsmpm_wide_kernels_avx2
  use qsmpm_kinds, only: wp
  use qsmpm_wide_kernels, only: width, first_of, second_of
  implicit none
  private

  public :: find_tensors, add_forces, form_stiffness

contains

  include 'wide_kernels.inc'
end module qsmpm_wide_kernels_avx2
