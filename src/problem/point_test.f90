!> Definition of a laboratory test on one material point: its kind, initial state and stages. Plain data; the control
!> of a test is implemented in qsmpm_point_stages.
!>
!> For laboratory quantities (axial strain, cell pressure, ...) compression is positive, for tensor components tension.
!> The axis of the specimen is y, as is the height in simple shear.
module qsmpm_point_test
  use qsmpm_kinds, only: wp
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: point_test_type, point_stage_type

  !> Kinds of tests.
  integer, parameter, public :: test_oedometer = 1, test_drained = 2, test_undrained = 3, test_biaxial = 4, &
    test_shear = 5, test_isotropic = 6, test_path = 7
  !> Definition of strain: change of length over initial length, or its logarithm.
  integer, parameter, public :: strain_engineering = 1, strain_logarithmic = 2

  !> Quantities that a stage may prescribe: laboratory quantities, nine components of the deformation gradient, six
  !> strains and six stresses.
  integer, parameter, public :: driven_axial_strain = 1, driven_axial_stress = 2, driven_deviator = 3, &
    driven_cell_pressure = 4, driven_shear_strain = 5, driven_shear_stress = 6, driven_normal_stress = 7, &
      driven_pressure = 8, &
    driven_volumetric_strain = 9
  integer, parameter, public :: driven_gradient = 9, driven_strain = 18, driven_stress = 24, driven_count = 30
  character(len=17), parameter, public :: driven_words(driven_count) = [character(len=17) :: &
    'AXIAL STRAIN', 'AXIAL STRESS', 'DEVIATOR', 'CELL PRESSURE', 'SHEAR STRAIN', 'SHEAR STRESS', 'NORMAL STRESS', &
    'PRESSURE', 'VOLUMETRIC STRAIN', 'F11', 'F21', 'F31', 'F12', 'F22', 'F32', 'F13', 'F23', 'F33', &
    'E11', 'E22', 'E33', 'E12', 'E13', 'E23', 'S11', 'S22', 'S33', 'S12', 'S13', 'S23']
  !> Row and column of the quantities that are components; for a strain or stress also its index in the order of
  !> stress.
  integer, parameter, public :: driven_row(driven_count) = [0, 0, 0, 0, 0, 0, 0, 0, 0, &
    1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 1, 2, 1, 2, 3, 1, 1, 2]
  integer, parameter, public :: driven_column(driven_count) = [0, 0, 0, 0, 0, 0, 0, 0, 0, &
    1, 1, 1, 2, 2, 2, 3, 3, 3, 1, 2, 3, 2, 3, 3, 1, 2, 3, 2, 3, 3]

  !> A stage of a test: quantities vary from their current values to their targets. With a table every row is a target.
  type :: point_stage_type
    type(source_line_type) :: where
    !> Number of steps to each target.
    integer :: steps = 50
    !> Duration of the stage, for time-dependent models; for a table with a time column, the time of each row from the
    !> start of the stage (row).
    real(wp) :: duration = 1.0_wp
    logical :: duration_given = .false.
    real(wp), allocatable :: times(:)
    !> Full path of a table of targets; empty for data lines.
    character(len=:), allocatable :: table
    !> Prescribed quantities and their targets (quantity, row).
    integer, allocatable :: driven_components(:)
    real(wp), allocatable :: targets(:, :)
  end type point_stage_type

  !> A laboratory test on one point.
  type :: point_test_type
    logical :: given = .false.
    type(source_line_type) :: where
    integer :: kind = test_path
    character(len=:), allocatable :: material
    !> 2 or 3: dimension of the law.
    integer :: dimension = 3
    integer :: strain = strain_engineering
    !> Whether simple shear is at constant height.
    logical :: fixed_height = .false.
    !> Allowed stress error relative to the largest stress of the step.
    real(wp) :: tolerance = 1.0e-10_wp
    !> Initial Cauchy stress in the order of stress; whether it is given in the deck.
    real(wp) :: stress(6) = 0.0_wp
    logical :: stress_given = .false.
    !> Initial total lateral stress of an undrained test, compression positive.
    real(wp) :: cell_pressure = 0.0_wp
    logical :: cell_given = .false.
    !> Time at the start.
    real(wp) :: start_time = 0.0_wp
    type(point_stage_type), allocatable :: stages(:)
  end type point_test_type
end module qsmpm_point_test
