!> Soil bodies as defined in a deck: their boundaries, material points, and changes by phases.
module qsmpm_body_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: body_type, body_change_type, drain_state_type

  !> Kinds of boundary of a body.
  integer, parameter, public :: body_all = 1, body_box = 2, body_polygon = 3, body_region = 4, &
    body_polyhedron = 5
  !> Shape of an activated body at its base: extended to the soil below, or its initial shape.
  integer, parameter, public :: fill_level = 1, fill_shape = 2

  !> A body of material and the density of its material points.
  type, extends(named_type) :: body_type
    character(len=:), allocatable :: material
    type(source_line_type) :: where
    integer :: kind = body_all
    real(wp) :: box(3, 2) = 0.0_wp
    !> Vertices in the x-y plane, counter-clockwise (2,n); extends through all z in 3D.
    real(wp), allocatable :: polygon(:, :)
    !> Element set of the mesh.
    character(len=:), allocatable :: region
    !> STL file of a polyhedron: path relative to the working directory.
    character(len=:), allocatable :: file
    !> Points per element; 0 for the default of the element.
    integer :: points_per_element = 0
    !> Whether the body is active from the start; otherwise a phase activates it.
    logical :: active = .true.
    !> Ratio of the volume of the body in the initial scene to that in a reduced model.
    real(wp) :: copies = 1.0_wp
  end type body_type

  !> Change of a body by a phase: activation, deactivation, or change of material.
  type :: body_change_type
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    character(len=:), allocatable :: material
    integer :: fill = fill_level
  end type body_change_type

  !> Treatment of the excess pore pressure of undrained materials in a phase and after it.
  type :: drain_state_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> Whether the existing pressure is retained and only new pressure is prevented.
    logical :: keeps = .false.
    !> Whether the material remains drained in later phases.
    logical :: stays_drained = .false.
    !> Bodies concerned; empty: all.
    type(string_type), allocatable :: bodies(:)
  end type drain_state_type
end module qsmpm_body_description
