!> What a deck says of a laboratory test on one material point: its kind, its state at the start and its stages.
!> Plain data; how a test is controlled is said in qsmpm_point_stages.
!>
!> Quantities of the laboratory (axial strain, cell pressure, ...) count compression positive, components of tensors
!> tension. The specimen's axis is y, and the height in simple shear too.
module qsmpm_point_test
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: point_test_type, point_stage_type

  !> Kinds of tests.
  integer, parameter, public :: test_oedometer = 1, test_drained = 2, test_undrained = 3, test_biaxial = 4, &
    test_shear = 5, test_isotropic = 6, test_path = 7
  !> What a strain is: change of length over the first length, or its logarithm.
  integer, parameter, public :: strain_engineering = 1, strain_logarithmic = 2

  !> Quantities a stage may lead: of the laboratory, then nine components of the deformation gradient, six strains
  !> and six stresses.
  integer, parameter, public :: driven_axial_strain = 1, driven_axial_stress = 2, driven_deviator = 3, &
    driven_cell_pressure = 4, driven_shear_strain = 5, driven_shear_stress = 6, driven_normal_stress = 7, &
      driven_pressure = 8, &
    driven_volumetric_strain = 9
  integer, parameter, public :: driven_gradient = 9, driven_strain = 18, driven_stress = 24, driven_count = 30
  character(len=17), parameter, public :: driven_words(driven_count) = [character(len=17) :: &
    'AXIAL STRAIN', 'AXIAL STRESS', 'DEVIATOR', 'CELL PRESSURE', 'SHEAR STRAIN', 'SHEAR STRESS', 'NORMAL STRESS', &
    'PRESSURE', 'VOLUMETRIC STRAIN', 'F11', 'F21', 'F31', 'F12', 'F22', 'F32', 'F13', 'F23', 'F33', &
    'E11', 'E22', 'E33', 'E12', 'E13', 'E23', 'S11', 'S22', 'S33', 'S12', 'S13', 'S23']
  !> Row and column of the quantities that are components; of a strain or stress also its place in stress order.
  integer, parameter, public :: driven_row(driven_count) = [0, 0, 0, 0, 0, 0, 0, 0, 0, &
    1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 1, 2, 1, 2, 3, 1, 1, 2]
  integer, parameter, public :: driven_column(driven_count) = [0, 0, 0, 0, 0, 0, 0, 0, 0, &
    1, 1, 1, 2, 2, 2, 3, 3, 3, 1, 2, 3, 2, 3, 3, 1, 2, 3, 2, 3, 3]

  !> A part of a test: quantities go from what they are to their targets. With a file every row is a target.
  type :: point_stage_type
    !> File and line of the card.
    character(len=:), allocatable :: file
    integer :: line = 0
    !> Steps to each target.
    integer :: steps = 50
    !> How long the stage lasts, for models that depend on time; of a table with a column of times, from the start of
    !> the stage to each row (row).
    real(wp) :: duration = 1.0_wp
    logical :: duration_given = .false.
    real(wp), allocatable :: times(:)
    !> Table of targets by its full path; empty for data lines.
    character(len=:), allocatable :: table
    !> Quantities prescribed, and their targets (quantity, row).
    integer, allocatable :: driven_components(:)
    real(wp), allocatable :: targets(:, :)
  end type point_stage_type

  !> The test.
  type :: point_test_type
    logical :: given = .false.
    character(len=:), allocatable :: file
    integer :: line = 0
    integer :: kind = test_path
    character(len=:), allocatable :: material
    !> 2 or 3: components the law works with.
    integer :: dimension = 3
    integer :: strain = strain_engineering
    !> Simple shear at fixed height.
    logical :: fixed_height = .false.
    !> Stress error allowed, over the largest stress of the step.
    real(wp) :: tolerance = 1.0e-10_wp
    !> Cauchy stress at the start in stress order, and whether a card said it.
    real(wp) :: stress(6) = 0.0_wp
    logical :: stress_given = .false.
    !> Total lateral stress of an undrained test at the start, compression positive.
    real(wp) :: cell_pressure = 0.0_wp
    logical :: cell_given = .false.
    !> Time at the start.
    real(wp) :: start_time = 0.0_wp
    type(point_stage_type), allocatable :: stages(:)
  end type point_test_type
end module qsmpm_point_test
