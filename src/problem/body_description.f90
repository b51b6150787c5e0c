!> Bodies of soil as a deck describes them: how they are bounded and filled, and how a phase changes them.
module qsmpm_body_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: body_type, body_change_type, drain_state_type

  !> How a body is bounded.
  integer, parameter, public :: body_all = 1, body_box = 2, body_polygon = 3, body_region = 4, &
    body_polyhedron = 5
  !> How a body that is put in place meets the ground below: stretched down to it, or as it is drawn.
  integer, parameter, public :: fill_level = 1, fill_shape = 2

  !> A body of material, and how densely it is seeded.
  type, extends(named_type) :: body_type
    character(len=:), allocatable :: material
    type(source_line_type) :: where
    integer :: kind = body_all
    real(wp) :: box(3, 2) = 0.0_wp
    !> Vertices in the x-y plane, counter-clockwise, (2,n); through all of z in 3D.
    real(wp), allocatable :: polygon(:, :)
    !> Element set of the mesh.
    character(len=:), allocatable :: region
    !> STL file of a polyhedron: path relative to the working directory.
    character(len=:), allocatable :: file
    !> Points per element; 0 asks for the element's default.
    integer :: points_per_element = 0
    !> It is there from the start; else a phase puts it in place.
    logical :: active = .true.
    !> How often the scene as drawn holds what a reduced model does of the body.
    real(wp) :: copies = 1.0_wp
  end type body_type

  !> What a phase does to a body: put in place, taken out, or of another material from then on.
  type :: body_change_type
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    character(len=:), allocatable :: material
    integer :: fill = fill_level
  end type body_change_type

  !> What becomes of the excess pore pressure of undrained materials in a phase, and after it.
  type :: drain_state_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> The pressure stays as it is, and only new one does not come about.
    logical :: keeps = .false.
    !> The material is drained in later phases too.
    logical :: stays_drained = .false.
    !> Bodies it is about; none: all.
    type(string_type), allocatable :: bodies(:)
  end type drain_state_type
end module qsmpm_body_description
