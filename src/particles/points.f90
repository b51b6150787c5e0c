!> Sets of points that move with the material: material points, surface points and tracers, as structures of arrays.
!>
!> A *carried* set has positions, an owner cell for each and local coordinates in it. It is moved by the displacement of
!> the step and located again after the mesh is reset (paper, section 3.3). Material points have the state of the
!> continuum; surface points have tractions; tracers have no state and only record the motion of a point of the body.
!>
!> The arrays have names for the procedures that compute with them. Procedures that treat all fields alike loop over
!> `list_fields` (qsmpm_field_list): a new field needs its declaration, a line there and its allocation in `allocate_*`,
!> all here.
!>
!> Derived fields of the material points: their displacement, strains if the deformation is stored, and the total stress
!> if pore pressures are stored.
module qsmpm_points
  use qsmpm_kinds, only: wp, long
  use qsmpm_field_list, only: field_list_type, kind_number, kind_amount, kind_position, kind_vector, kind_tensor, &
    kind_label, kind_internal, shown_by_name, shown_everywhere, unit_length, unit_area, unit_volume, unit_force, &
    unit_stress
  use qsmpm_isotropic_function, only: logarithmic_strain, shear_strain, volume_strain
  implicit none
  private

  public :: carried_type, points_type, surface_points_type, watched_points_type, place_of, allocate_carried, &
    allocate_points, allocate_surface_points, allocate_watched, copy_points, start_strains, carries_strains, &
    reset_strains, start_water, carries_water, carry_as, set_normals, list_made_fields, nearest_point

  !> Points that move with the material.
  type :: carried_type
    integer :: count = 0
    !> Number of a point, constant as long as it exists, independent of its position in the arrays; unique in its set
    !> (count).
    integer(long), allocatable :: number(:)
    !> Current and initial position (dimension, count).
    real(wp), allocatable :: position(:, :), initial_position(:, :)
    !> Local coordinates in the owner cell (dimension, count).
    real(wp), allocatable :: local(:, :)
    !> Owner cell (count).
    integer, allocatable :: cell(:)
  contains
    !> Adds the fields to a list, which is valid as long as the object, a target, exists.
    procedure :: list_fields => list_carried
  end type carried_type

  !> Material points (paper, section 3.1).
  type, extends(carried_type) :: points_type
    !> Body and material number, and foot under the point (0 for none; qsmpm_inactive_points) (count).
    integer, allocatable :: body(:), material(:), foot(:)
    !> Current and initial volume (per radian in axisymmetry), and weight per unit gravity. The weight is stored,
    !> because eq. 29 with a constant density would not conserve it. It reaches its value at the end of the phase, from
    !> another one at the start if the body is activated or its material is changed.
    real(wp), allocatable :: volume(:), initial_volume(:), weight(:), start_weight(:)
    !> Cauchy stress, 11,22,33,12[,13,23] (4 or 6, count).
    real(wp), allocatable :: stress(:, :)
    !> State of the law (largest state_count of all laws, count).
    real(wp), allocatable :: state(:, :)
    !> 1 if the point yielded in the last step.
    integer, allocatable :: plastic(:)
    !> Half lengths along the axes of the box that a point initially represents (dimension, count): half the piece of a
    !> regular pattern, otherwise a box with the shape of the cell and the volume of the point. Never changed.
    real(wp), allocatable :: half_size(:, :)
    !> Total deformation gradient, packed; no columns unless domains require it (5 or 9, count or 0).
    real(wp), allocatable :: deformation_gradient(:, :)
    !> Left Cauchy-Green tensor of the total deformation in stress order, and accumulated plastic shear strain
    !> (qsmpm_isotropic_function); no columns unless results require strains (4 or 6, count or 0), (count or 0).
    real(wp), allocatable :: left_cauchy_green(:, :), plastic_strain(:)
    !> Pore water pressure, compression positive: hydrostatic below a water level, and including the excess pressure of
    !> undrained laws; empty if the model has no water (count or 0).
    real(wp), allocatable :: steady_pore_pressure(:), pore_pressure(:)
    !> Values passed to user-defined models: excess part of the pore pressure, degree of saturation (2, count or 0).
    real(wp), allocatable :: pore_state(:, :)
  contains
    procedure :: list_fields => list_points
  end type points_type

  !> Surface points: quadrature points of the loaded surfaces.
  type, extends(carried_type) :: surface_points_type
    !> Surface number, body and foot (0 for none), and undeformed area (per radian in axisymmetry) of each.
    integer, allocatable :: surface(:), body(:), foot(:)
    real(wp), allocatable :: area(:)
    !> Outward unit normal times current area (dimension, count).
    real(wp), allocatable :: area_vector(:, :)
    !> Unit normal at the start of the support of the surface (dimension, count); the position at that time is the
    !> initial position.
    real(wp), allocatable :: normal(:, :)
    !> Force of the support on the body after the last step, and previous force of a support that this phase removes or
    !> changes, which decreases to zero over the phase (dimension, count).
    real(wp), allocatable :: reaction(:, :), released(:, :)
    !> Pressure and shear traction of a rigid body on the soil after the last step, per area at the end of the step
    !> (count), (dimension, count).
    real(wp), allocatable :: contact_pressure(:), contact_shear(:, :)
    !> Slip of the soil along the body since contact began (dimension, count).
    real(wp), allocatable :: contact_slip(:, :)
  contains
    procedure :: list_fields => list_surface_points
  end type surface_points_type

  !> Points on the faces of prescribed node sets that move with the material (qsmpm_pushed_material).
  type, extends(carried_type) :: watched_points_type
    !> Node set and prescribed component of each, and accumulated prescribed displacement (count).
    integer, allocatable :: set(:), component(:)
    real(wp), allocatable :: pushed(:)
  contains
    procedure :: list_fields => list_watched
  end type watched_points_type

contains

  !> Lists the fields of every carried set.
  subroutine list_carried(self, list)
    class(carried_type), intent(in), target :: self
    type(field_list_type), intent(inout) :: list

    call list%add('position', kind_position, shown_everywhere, unit_length, 'present position', table=self%position)
    call list%add('initial_position', kind_position, shown_by_name, unit_length, &
      'position at the start, or where displacements were set to zero last', table=self%initial_position)
    call list%add('local_coordinate', kind_internal, table=self%local)
    call list%add('cell', kind_internal, labels=self%cell)
    call list%add('number', kind_internal, numbers=self%number)
  end subroutine list_carried

  !> Lists the fields of the material points.
  subroutine list_points(self, list)
    class(points_type), intent(in), target :: self
    type(field_list_type), intent(inout) :: list

    call self%carried_type%list_fields(list)
    call list%add('stress', kind_tensor, shown_everywhere, unit_stress, 'Cauchy stress', table=self%stress)
    call list%add('volume', kind_amount, shown_everywhere, unit_volume, 'present volume', row=self%volume)
    call list%add('initial_volume', kind_amount, shown_everywhere, unit_volume, &
      'volume at the start, or where initial stresses were set', row=self%initial_volume)
    call list%add('weight', kind_amount, shown_by_name, unit_force, 'weight under unit gravity', row=self%weight)
    call list%add('plastic', kind_label, shown_everywhere, meaning='1 where the point yielded in the '// &
      'last step', labels=self%plastic)
    call list%add('material', kind_label, shown_everywhere, meaning='number of the material', labels=self%material)
    call list%add('body', kind_label, shown_by_name, meaning='number of the body', labels=self%body)
    call list%add('foot', kind_internal, labels=self%foot)
    call list%add('start_weight', kind_internal, row=self%start_weight)
    call list%add('state', kind_internal, shown_by_name, meaning='state variables of the law, all', table=self%state)
    call list%add('half_size', kind_internal, table=self%half_size)
    call list%add('deformation_gradient', kind_internal, table=self%deformation_gradient)
    call list%add('left_cauchy_green', kind_tensor, shown_by_name, meaning='left '// &
      'Cauchy-Green tensor b = F F^T of the total deformation', table=self%left_cauchy_green)
    call list%add('accumulated_plastic_shear_strain', kind_number, shown_everywhere, &
      meaning='sum over the steps of (2 e:e)^1/2, e the deviator of the plastic strain of a step', &
      row=self%plastic_strain)
    call list%add('steady_pore_pressure', kind_number, shown_by_name, unit_stress, &
      'pressure of the water at rest below the water level, compression positive', row=self%steady_pore_pressure)
    call list%add('pore_pressure', kind_number, shown_everywhere, unit_stress, &
      'pressure of the water in the pores, steady and excess, compression positive', row=self%pore_pressure)
    call list%add('pore_state', kind_internal, table=self%pore_state)
  end subroutine list_points

  !> Lists the fields of the surface points.
  subroutine list_surface_points(self, list)
    class(surface_points_type), intent(in), target :: self
    type(field_list_type), intent(inout) :: list

    call self%carried_type%list_fields(list)
    call list%add('surface', kind_label, labels=self%surface)
    call list%add('body', kind_internal, labels=self%body)
    call list%add('foot', kind_internal, labels=self%foot)
    call list%add('area', kind_amount, unit=unit_area, row=self%area)
    call list%add('area_vector', kind_vector, unit=unit_area, table=self%area_vector)
    call list%add('normal', kind_vector, table=self%normal)
    call list%add('reaction', kind_vector, unit=unit_force, table=self%reaction)
    call list%add('released', kind_vector, unit=unit_force, table=self%released)
    call list%add('contact_pressure', kind_number, unit=unit_stress, row=self%contact_pressure)
    call list%add('contact_shear', kind_vector, unit=unit_stress, table=self%contact_shear)
    call list%add('contact_slip', kind_vector, unit=unit_length, table=self%contact_slip)
  end subroutine list_surface_points

  !> Lists the fields of the watched points.
  subroutine list_watched(self, list)
    class(watched_points_type), intent(in), target :: self
    type(field_list_type), intent(inout) :: list

    call self%carried_type%list_fields(list)
    call list%add('set', kind_label, labels=self%set)
    call list%add('component', kind_label, labels=self%component)
    call list%add('pushed', kind_number, unit=unit_length, row=self%pushed)
  end subroutine list_watched

  !> Position of a point as three coordinates, the third 0 in 2D.
  pure function place_of(carried, number) result(place)
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: number
    real(wp) :: place(3)

    place = 0.0_wp
    place(:size(carried%position, 1)) = carried%position(:, number)
  end function place_of

  !> Material point nearest to a position, of one body (0 if it has none) or of all; the first of equally near ones.
  pure integer function nearest_point(points, x, body) result(nearest)
    type(points_type), intent(in) :: points
    !> Position (dimension).
    real(wp), intent(in) :: x(:)
    integer, intent(in), optional :: body
    real(wp) :: distance, least
    integer :: p

    nearest = merge(0, 1, present(body))
    least = huge(least)
    do p = 1, points%count
      if (present(body)) then
        if (points%body(p) /= body) cycle
      end if
      distance = sum((points%position(:, p) - x)**2)
      if (distance >= least) cycle
      least = distance
      nearest = p
    end do
  end function nearest_point

  !> Allocates the arrays of a carried set; its points are numbered in their order.
  pure subroutine allocate_carried(carried, dimension, count)
    !> Set that moves with the material.
    class(carried_type), intent(inout) :: carried
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of points.
    integer, intent(in) :: count
    integer :: i

    carried%count = count
    allocate (carried%position(dimension, count), carried%initial_position(dimension, count), &
      carried%local(dimension, count), source=0.0_wp)
    allocate (carried%cell(count), source=0)
    allocate (carried%number(count), source=[(int(i, long), i=1, count)])
  end subroutine allocate_carried

  !> Allocates material points, unstressed and undeformed.
  pure subroutine allocate_points(points, dimension, count, stress_components, state_count)
    type(points_type), intent(out) :: points
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of points.
    integer, intent(in) :: count
    !> 4 or 6.
    integer, intent(in) :: stress_components
    !> Number of state variables per point.
    integer, intent(in) :: state_count

    call allocate_carried(points, dimension, count)
    allocate (points%body(count), points%material(count), points%plastic(count), points%foot(count), &
      source=0)
    allocate (points%volume(count), points%initial_volume(count), points%weight(count), points%start_weight(count), &
      source=0.0_wp)
    allocate (points%stress(stress_components, count), points%state(state_count, count), &
      source=0.0_wp)
    allocate (points%half_size(dimension, count), points%deformation_gradient(4*dimension - 3, 0), &
      points%left_cauchy_green(stress_components, 0), points%plastic_strain(0), points%steady_pore_pressure(0), &
      points%pore_pressure(0), points%pore_state(2, 0), source=0.0_wp)
  end subroutine allocate_points

  !> Allocates the strains, initially zero.
  pure subroutine start_strains(points)
    type(points_type), intent(inout) :: points

    deallocate (points%left_cauchy_green, points%plastic_strain)
    allocate (points%left_cauchy_green(size(points%stress, 1), points%count), points%plastic_strain(points%count))
    call reset_strains(points)
  end subroutine start_strains

  !> Whether strains are stored.
  pure logical function carries_strains(points)
    type(points_type), intent(in) :: points

    carries_strains = size(points%plastic_strain) > 0
  end function carries_strains

  !> Sets the strains to zero if they are stored; the arrays are not reallocated.
  pure subroutine reset_strains(points)
    type(points_type), intent(inout) :: points

    points%plastic_strain = 0.0_wp
    points%left_cauchy_green = 0.0_wp
    points%left_cauchy_green(1:3, :) = 1.0_wp
  end subroutine reset_strains

  !> Allocates the pore pressures, initially zero.
  pure subroutine start_water(points)
    type(points_type), intent(inout) :: points

    deallocate (points%steady_pore_pressure, points%pore_pressure, points%pore_state)
    allocate (points%steady_pore_pressure(points%count), points%pore_pressure(points%count), source=0.0_wp)
    allocate (points%pore_state(2, points%count), source=spread([0.0_wp, 1.0_wp], 2, points%count))
  end subroutine start_water

  !> Whether pore pressures are stored.
  pure logical function carries_water(points)
    type(points_type), intent(in) :: points

    carries_water = size(points%pore_pressure) > 0
  end function carries_water

  !> Allocates the optional fields that other points have.
  pure subroutine carry_as(points, like)
    type(points_type), intent(inout) :: points
    type(points_type), intent(in) :: like

    if (carries_strains(like)) call start_strains(points)
    if (carries_water(like)) call start_water(points)
  end subroutine carry_as

  !> Copies material points. Arrays of the same size are not reallocated, which an assignment of the whole object does
  !> not guarantee.
  subroutine copy_points(from, to)
    type(points_type), intent(in), target :: from
    type(points_type), intent(inout), target :: to
    type(field_list_type) :: source, copy
    integer :: i
    logical :: same

    call from%list_fields(source)
    call to%list_fields(copy)
    same = from%count == to%count
    same = same .and. all([(source%fields(i)%component_count() == copy%fields(i)%component_count() &
      .and. source%fields(i)%point_count() == copy%fields(i)%point_count(), i=1, source%count)])
    if (same) then
      call copy_fields(source, copy)
    else
      to = from
    end if
  end subroutine copy_points

  !> Copies the values of fields to fields of the same sizes.
  subroutine copy_fields(from, to)
    type(field_list_type), intent(in) :: from
    type(field_list_type), intent(inout) :: to
    integer :: i

    do i = 1, from%count
      if (associated(from%fields(i)%reals)) to%fields(i)%reals = from%fields(i)%reals
      if (associated(from%fields(i)%labels)) to%fields(i)%labels = from%fields(i)%labels
      if (associated(from%fields(i)%numbers)) to%fields(i)%numbers = from%fields(i)%numbers
    end do
  end subroutine copy_fields

  !> Allocates surface points of zero area.
  pure subroutine allocate_surface_points(surface, dimension, count)
    type(surface_points_type), intent(out) :: surface
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of surface points.
    integer, intent(in) :: count

    call allocate_carried(surface, dimension, count)
    allocate (surface%surface(count), surface%body(count), surface%foot(count), source=0)
    allocate (surface%area(count), surface%contact_pressure(count), source=0.0_wp)
    allocate (surface%area_vector(dimension, count), surface%normal(dimension, count), &
      surface%reaction(dimension, count), surface%released(dimension, count), &
      surface%contact_shear(dimension, count), surface%contact_slip(dimension, count), source=0.0_wp)
  end subroutine allocate_surface_points

  !> Allocates watched points without a set.
  pure subroutine allocate_watched(watched, dimension, count)
    type(watched_points_type), intent(out) :: watched
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of points.
    integer, intent(in) :: count

    call allocate_carried(watched, dimension, count)
    allocate (watched%set(count), watched%component(count), source=0)
    allocate (watched%pushed(count), source=0.0_wp)
  end subroutine allocate_watched

  !> Sets initial position and normal of surface points to the current ones, for the start of their support.
  pure subroutine set_normals(surface, chosen)
    type(surface_points_type), intent(inout) :: surface
    !> Points that are set (count).
    logical, intent(in) :: chosen(:)
    integer :: i

    do i = 1, surface%count
      if (.not. chosen(i)) cycle
      surface%initial_position(:, i) = surface%position(:, i)
      surface%normal(:, i) = surface%area_vector(:, i) &
        /max(norm2(surface%area_vector(:, i)), tiny(1.0_wp))
    end do
  end subroutine set_normals

  !> Adds displacement, strains and total stress; fields that are not stored have no columns.
  subroutine list_made_fields(points, list)
    type(points_type), intent(in) :: points
    type(field_list_type), intent(inout) :: list
    real(wp), allocatable :: displacement(:, :), strain(:, :), volume(:, :), shear(:, :), total(:, :)
    integer :: p

    allocate (displacement, source=points%position - points%initial_position)
    allocate (strain, mold=points%left_cauchy_green)
    allocate (volume(1, size(strain, 2)), shear(1, size(strain, 2)))
    do p = 1, size(strain, 2)
      strain(:, p) = logarithmic_strain(points%left_cauchy_green(:, p))
      volume(1, p) = volume_strain(strain(:, p))
      shear(1, p) = shear_strain(strain(:, p))
    end do
    call list%add_made('displacement', displacement, kind_vector, shown_everywhere, unit_length, &
      'position less initial position')
    call list%add_made('strain', strain, kind_tensor, shown_everywhere, meaning='logarithmic strain 1/2 ln b; '// &
      'shear components are engineering strains')
    call list%add_made('volume_strain', volume, kind_number, shown_everywhere, meaning='ln J, trace of the strain')
    call list%add_made('shear_strain', shear, kind_number, shown_everywhere, meaning='(2 e:e)^1/2, e the deviator '// &
      'of the strain; 3^1/2 times the triaxial eps_q')
    allocate (total(size(points%stress, 1), merge(points%count, 0, carries_water(points))))
    do p = 1, size(total, 2)
      total(:, p) = points%stress(:, p)
      total(1:3, p) = total(1:3, p) - points%steady_pore_pressure(p)
    end do
    call list%add_made('total_stress', total, kind_tensor, shown_everywhere, unit_stress, &
      'stress of soil and water together, tension positive')
  end subroutine list_made_fields
end module qsmpm_points
