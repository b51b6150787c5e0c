!> The analysis defined by a deck, as plain data: filled by the deck reader or by an embedding program, and used to
!> build the model. It has no procedures; every file name is resolved once and every default is defined once, here.
!>
!> Names of sets, surfaces and materials are stored as text; the model builder resolves them against the mesh and
!> reports unknown names. Lengths, forces and stresses are in the consistent units of the deck. Vectors have three
!> components; the third is unused in plane models.
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
  !> Whether a reduced model may be half of a symmetric scene: if no condition excludes it, whenever the scene is
  !> symmetric, never.
  integer, parameter, public :: mirror_auto = 0, mirror_yes = 1, mirror_no = 2

  !> All data of a deck.
  type :: analysis_type
    !> Path of the deck and its base name without extension; keywords used in the deck, each once.
    character(len=:), allocatable :: deck, job
    type(string_type), allocatable :: cards(:)
    !> Heading lines joined by newlines.
    character(len=:), allocatable :: heading
    character(len=:), allocatable :: length_unit, force_unit
    integer :: model = 0
    !> Whether the smallest equivalent model is sought, which may be half of a symmetric scene.
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
    !> Recommended method of a deck that defines none, with the reason.
    character(len=:), allocatable :: method_reason
    !> Initial background and the one that replaces it when it is too distorted; unallocated if there is no
    !> replacement.
    type(background_type), allocatable :: backgrounds(:)
    type(solver_choice_type) :: solver
    type(moving_mesh_type) :: moving_mesh
    !> Confining pressure on every free boundary of the soil, compression positive.
    real(wp) :: confinement = 0.0_wp
    type(history_type), allocatable :: histories(:)
    type(output_request_type) :: output
    type(phase_type), allocatable :: phases(:)
    !> Laboratory test on one point, which replaces a scene.
    type(point_test_type) :: point_test
  end type analysis_type
end module qsmpm_analysis
