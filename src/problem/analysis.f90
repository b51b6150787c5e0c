!> The analysis a deck describes, as plain data: what the parser fills, what an embedding program
!> may fill by hand, and what the model is built from. No procedure, no file name resolved twice,
!> every default stated here once.
!>
!> Names of sets, surfaces and materials are kept as text; the model builder resolves them against
!> the mesh and reports the unknown ones. Lengths, forces and stresses are in the deck's consistent
!> units. Vectors have three components; the third is unused in the plane.
module qsmpm_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_body_description, only: body_type
  use qsmpm_history_description, only: history_type, output_request_type
  use qsmpm_material_description, only: material_type
  use qsmpm_mesh_description, only: mesh_source_type, set_type, surface_type, moving_mesh_type
  use qsmpm_method_description, only: method_type, solver_choice_type, background_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_point_test, only: point_test_type
  use qsmpm_structures, only: rigid_body_type, contact_type, prop_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: analysis_type

  !> Kinds of model.
  integer, parameter, public :: plane_strain = 1, axisymmetric = 2, three_dimensional = 3
  !> Whether a reduced model may be half of a symmetric scene: where nothing speaks against it, whenever
  !> the scene is symmetric, never.
  integer, parameter, public :: mirror_auto = 0, mirror_yes = 1, mirror_no = 2

  !> Everything a deck says.
  type :: analysis_type
    !> Path of the deck and its base name without extension; keywords of the cards it has, each once.
    character(len=:), allocatable :: deck, job
    type(string_type), allocatable :: cards(:)
    !> Heading lines joined by newlines.
    character(len=:), allocatable :: heading
    character(len=:), allocatable :: length_unit, force_unit
    integer :: model = 0
    !> The smallest model that answers is looked for, and may be half of a symmetric scene.
    logical :: reduce = .false.
    integer :: mirror = mirror_auto
    type(mesh_source_type) :: mesh
    type(set_type), allocatable :: node_sets(:), element_sets(:)
    type(surface_type), allocatable :: surfaces(:)
    type(body_type), allocatable :: bodies(:)
    type(rigid_body_type), allocatable :: rigid_bodies(:)
    type(contact_type), allocatable :: contacts(:)
    type(prop_type), allocatable :: props(:)
    type(material_type), allocatable :: materials(:)
    type(method_type) :: method
    !> Method that is recommended for a deck that names none, and why.
    character(len=:), allocatable :: method_reason
    !> Of the start, and what follows when that is worn; unallocated where nothing follows.
    type(background_type), allocatable :: backgrounds(:)
    type(solver_choice_type) :: solver
    type(moving_mesh_type) :: moving_mesh
    !> All-round pressure on every free boundary of the soil, compression positive.
    real(wp) :: confinement = 0.0_wp
    type(history_type), allocatable :: histories(:)
    type(output_request_type) :: output
    type(phase_type), allocatable :: phases(:)
    !> A laboratory test on one point in place of a scene.
    type(point_test_type) :: point_test
  end type analysis_type
end module qsmpm_analysis
