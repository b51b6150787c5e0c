!> Everything that rides on the mesh: material points, surface points and tracers, as structures of
!> arrays.
!>
!> A *carried* set has positions, an owner cell each and local coordinates in it; it is moved by the
!> displacement of the step and found again after the mesh is reset (paper, section 3.3).
!> Material points carry the state of the continuum; surface points carry tractions; tracers carry
!> nothing and only record where a place of the body has gone.
module qsmpm_points
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: carried_type, points_type, surface_points_type, watched_points_type
  public :: place_of, allocate_carried, allocate_points, allocate_surface_points, allocate_watched, copy_points, &
    set_normals

  !> Places that move with the material.
  type :: carried_type
    integer :: count = 0
    !> Current and initial position (dimension, count).
    real(wp), allocatable :: position(:, :), initial_position(:, :)
    !> Local coordinates in the owner cell (dimension, count).
    real(wp), allocatable :: local(:, :)
    !> Owner cell (count).
    integer, allocatable :: cell(:)
  end type carried_type

  !> Material points (paper, section 3.1).
  type, extends(carried_type) :: points_type
    !> Body and material number (count).
    integer, allocatable :: body(:), material(:)
    !> Volume now and at the start (per radian in axisymmetry), and weight per unit gravity; the
    !> weight is kept: eq. 29 with a constant density would lose it.
    real(wp), allocatable :: volume(:), initial_volume(:), weight(:)
    !> Cauchy stress, 11,22,33,12[,13,23] (4 or 6, count).
    real(wp), allocatable :: stress(:, :)
    !> State of the law (largest state_count of all laws, count).
    real(wp), allocatable :: state(:, :)
    !> 1 where the point yielded in the last step.
    integer, allocatable :: plastic(:)
    !> Half lengths along the axes of the box a point stood for at the start (dimension, count): half
    !> the piece of a regular pattern, else shaped like its cell with its volume. Never changed.
    real(wp), allocatable :: half_size(:, :)
    !> Total deformation gradient, packed; no columns unless domains need it (5 or 9, count or 0).
    real(wp), allocatable :: deformation_gradient(:, :)
  end type points_type

  !> Surface points: quadrature points of the loaded surfaces.
  type, extends(carried_type) :: surface_points_type
    !> Surface number and undeformed area (per radian in axisymmetry) of each.
    integer, allocatable :: surface(:)
    real(wp), allocatable :: area(:)
    !> Outward unit normal times present area (dimension, count).
    real(wp), allocatable :: area_vector(:, :)
    !> Unit normal when the support of the surface began (dimension, count); the place then is the
    !> initial position.
    real(wp), allocatable :: normal(:, :)
    !> Force of the support on the body after the last step, and the one that a support which this phase has freed or
    !> changed exerted before: it falls to zero over the phase (dimension, count).
    real(wp), allocatable :: reaction(:, :), released(:, :)
  end type surface_points_type

  !> Places on the faces of prescribed node sets that ride with the material (qsmpm_pushed_material).
  type, extends(carried_type) :: watched_points_type
    !> Node set and prescribed component of each, and the displacement prescribed so far (count).
    integer, allocatable :: set(:), component(:)
    real(wp), allocatable :: pushed(:)
  end type watched_points_type

contains

  !> Position of one as three coordinates, the third 0 in the plane.
  pure function place_of(carried, number) result(place)
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: number
    real(wp) :: place(3)

    place = 0.0_wp
    place(:size(carried%position, 1)) = carried%position(:, number)
  end function place_of

  !> Allocate the arrays of a carried set.
  pure subroutine allocate_carried(carried, dimension, count)
    !> What rides on the mesh.
    class(carried_type), intent(inout) :: carried
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of places.
    integer, intent(in) :: count

    carried%count = count
    allocate (carried%position(dimension, count), carried%initial_position(dimension, count), &
      carried%local(dimension, count), source=0.0_wp)
    allocate (carried%cell(count), source=0)
  end subroutine allocate_carried

  !> Allocate material points, unstressed and undeformed.
  pure subroutine allocate_points(points, dimension, count, stress_components, state_count)
    !> The material points.
    type(points_type), intent(out) :: points
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of points.
    integer, intent(in) :: count
    !> 4 or 6.
    integer, intent(in) :: stress_components
    !> State variables a point.
    integer, intent(in) :: state_count

    call allocate_carried(points, dimension, count)
    allocate (points%body(count), points%material(count), points%plastic(count), source=0)
    allocate (points%volume(count), points%initial_volume(count), points%weight(count), &
      source=0.0_wp)
    allocate (points%stress(stress_components, count), points%state(state_count, count), &
      source=0.0_wp)
    allocate (points%half_size(dimension, count), points%deformation_gradient(4*dimension - 3, 0), &
      source=0.0_wp)
  end subroutine allocate_points

  !> Copy material points array by array: those of the same size stay where they are in memory, which an
  !> assignment of the whole does not promise.
  pure subroutine copy_points(from, to)
    !> The points.
    type(points_type), intent(in) :: from
    !> Their copy.
    type(points_type), intent(inout) :: to

    to%count = from%count
    to%position = from%position
    to%initial_position = from%initial_position
    to%local = from%local
    to%cell = from%cell
    to%body = from%body
    to%material = from%material
    to%volume = from%volume
    to%initial_volume = from%initial_volume
    to%weight = from%weight
    to%stress = from%stress
    to%state = from%state
    to%plastic = from%plastic
    to%half_size = from%half_size
    to%deformation_gradient = from%deformation_gradient
  end subroutine copy_points

  !> Allocate surface points of no area.
  pure subroutine allocate_surface_points(surface, dimension, count)
    !> The surface points.
    type(surface_points_type), intent(out) :: surface
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of surface points.
    integer, intent(in) :: count

    call allocate_carried(surface, dimension, count)
    allocate (surface%surface(count), source=0)
    allocate (surface%area(count), source=0.0_wp)
    allocate (surface%area_vector(dimension, count), surface%normal(dimension, count), &
      surface%reaction(dimension, count), surface%released(dimension, count), source=0.0_wp)
  end subroutine allocate_surface_points

  !> Allocate watched places of no set.
  pure subroutine allocate_watched(watched, dimension, count)
    type(watched_points_type), intent(out) :: watched
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of places.
    integer, intent(in) :: count

    call allocate_carried(watched, dimension, count)
    allocate (watched%set(count), watched%component(count), source=0)
    allocate (watched%pushed(count), source=0.0_wp)
  end subroutine allocate_watched

  !> Take the present place and normal of surface points for those at which their support begins.
  pure subroutine set_normals(surface, chosen)
    !> The surface points.
    type(surface_points_type), intent(inout) :: surface
    !> Which of them (count).
    logical, intent(in) :: chosen(:)
    integer :: i

    do i = 1, surface%count
      if (.not. chosen(i)) cycle
      surface%initial_position(:, i) = surface%position(:, i)
      surface%normal(:, i) = surface%area_vector(:, i) &
        /max(norm2(surface%area_vector(:, i)), tiny(1.0_wp))
    end do
  end subroutine set_normals
end module qsmpm_points
