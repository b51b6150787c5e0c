!> Everything that rides on the mesh: material points, surface points and tracers, as structures of
!> arrays.
!>
!> A *carried* set has positions, an owner cell each and local coordinates in it; it is moved by the
!> displacement of the step and found again after the mesh is reset (paper, section 3.3).
!> Material points carry the state of the continuum; surface points carry tractions; tracers carry
!> nothing and only record where a place of the body has gone.
!>
!> The arrays are named for those who compute with them. Whoever treats all fields alike loops over `list_fields`
!> (qsmpm_field_list): a new field is its declaration, its line there and its room in `allocate_*`, all here.
!>
!> Fields of the material points that are made from those they carry: the way they have gone, strains where the
!> deformation is carried, and the total stress where pore pressures are.
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

  !> Places that move with the material.
  type :: carried_type
    integer :: count = 0
    !> Number that a place keeps as long as it is there, whatever place in the arrays it has; unique in its set (count).
    integer(long), allocatable :: number(:)
    !> Current and initial position (dimension, count).
    real(wp), allocatable :: position(:, :), initial_position(:, :)
    !> Local coordinates in the owner cell (dimension, count).
    real(wp), allocatable :: local(:, :)
    !> Owner cell (count).
    integer, allocatable :: cell(:)
  contains
    !> Add the fields to a list; it is good as long as the object, a target, lives.
    procedure :: list_fields => list_carried
  end type carried_type

  !> Material points (paper, section 3.1).
  type, extends(carried_type) :: points_type
    !> Body and material number, and foot under the point (0 for none; qsmpm_inactive_points) (count).
    integer, allocatable :: body(:), material(:), foot(:)
    !> Volume now and at the start (per radian in axisymmetry), and weight per unit gravity; the
    !> weight is kept: eq. 29 with a constant density would lose it. It runs to its value over the phase from that at
    !> the start, which is another one where the body comes or gets another material.
    real(wp), allocatable :: volume(:), initial_volume(:), weight(:), start_weight(:)
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
    !> Left Cauchy-Green tensor of the total deformation in stress order, and accumulated plastic shear strain
    !> (qsmpm_isotropic_function); no columns unless results ask for strains (4 or 6, count or 0), (count or 0).
    real(wp), allocatable :: left_cauchy_green(:, :), plastic_strain(:)
    !> Pressure of the water in the pores, compression positive: of water at rest below a level, and with the excess
    !> that undrained laws carry; none where no scene has water (count or 0).
    real(wp), allocatable :: steady_pore_pressure(:), pore_pressure(:)
    !> As models of users are given it: excess in the pore pressure, filled share of the pores (2, count or 0).
    real(wp), allocatable :: pore_state(:, :)
  contains
    procedure :: list_fields => list_points
  end type points_type

  !> Surface points: quadrature points of the loaded surfaces.
  type, extends(carried_type) :: surface_points_type
    !> Surface number, body and foot (0 for none), and undeformed area (per radian in axisymmetry) of each.
    integer, allocatable :: surface(:), body(:), foot(:)
    real(wp), allocatable :: area(:)
    !> Outward unit normal times present area (dimension, count).
    real(wp), allocatable :: area_vector(:, :)
    !> Unit normal when the support of the surface began (dimension, count); the place then is the
    !> initial position.
    real(wp), allocatable :: normal(:, :)
    !> Force of the support on the body after the last step, and the one that a support which this phase has freed or
    !> changed exerted before: it falls to zero over the phase (dimension, count).
    real(wp), allocatable :: reaction(:, :), released(:, :)
    !> Pressure and shear traction of a rigid body on the soil after the last step, per area of its end
    !> (count), (dimension, count).
    real(wp), allocatable :: contact_pressure(:), contact_shear(:, :)
    !> How far the soil has slid along the body since they touched (dimension, count).
    real(wp), allocatable :: contact_slip(:, :)
  contains
    procedure :: list_fields => list_surface_points
  end type surface_points_type

  !> Places on the faces of prescribed node sets that ride with the material (qsmpm_pushed_material).
  type, extends(carried_type) :: watched_points_type
    !> Node set and prescribed component of each, and the displacement prescribed so far (count).
    integer, allocatable :: set(:), component(:)
    real(wp), allocatable :: pushed(:)
  contains
    procedure :: list_fields => list_watched
  end type watched_points_type

contains

  !> Fields of every carried set.
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

  !> Fields of the material points.
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

  !> Fields of the surface points.
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

  !> Fields of the watched places.
  subroutine list_watched(self, list)
    class(watched_points_type), intent(in), target :: self
    type(field_list_type), intent(inout) :: list

    call self%carried_type%list_fields(list)
    call list%add('set', kind_label, labels=self%set)
    call list%add('component', kind_label, labels=self%component)
    call list%add('pushed', kind_number, unit=unit_length, row=self%pushed)
  end subroutine list_watched

  !> Position of one as three coordinates, the third 0 in the plane.
  pure function place_of(carried, number) result(place)
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: number
    real(wp) :: place(3)

    place = 0.0_wp
    place(:size(carried%position, 1)) = carried%position(:, number)
  end function place_of

  !> Material point nearest to a place, of a body (0 when it has none) or of all; the first of equally near ones.
  pure integer function nearest_point(points, x, body) result(nearest)
    type(points_type), intent(in) :: points
    !> Place (dimension).
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

  !> Allocate the arrays of a carried set; its places are numbered as they stand.
  pure subroutine allocate_carried(carried, dimension, count)
    !> What rides on the mesh.
    class(carried_type), intent(inout) :: carried
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of places.
    integer, intent(in) :: count
    integer :: i

    carried%count = count
    allocate (carried%position(dimension, count), carried%initial_position(dimension, count), &
      carried%local(dimension, count), source=0.0_wp)
    allocate (carried%cell(count), source=0)
    allocate (carried%number(count), source=[(int(i, long), i=1, count)])
  end subroutine allocate_carried

  !> Allocate material points, unstressed and undeformed.
  pure subroutine allocate_points(points, dimension, count, stress_components, state_count)
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

  !> Carry strains from now on, none yet.
  pure subroutine start_strains(points)
    type(points_type), intent(inout) :: points

    deallocate (points%left_cauchy_green, points%plastic_strain)
    allocate (points%left_cauchy_green(size(points%stress, 1), points%count), points%plastic_strain(points%count))
    call reset_strains(points)
  end subroutine start_strains

  !> Whether strains are carried.
  pure logical function carries_strains(points)
    type(points_type), intent(in) :: points

    carries_strains = size(points%plastic_strain) > 0
  end function carries_strains

  !> Set the strains to zero where they are carried; the arrays stay where they are in memory.
  pure subroutine reset_strains(points)
    type(points_type), intent(inout) :: points

    points%plastic_strain = 0.0_wp
    points%left_cauchy_green = 0.0_wp
    points%left_cauchy_green(1:3, :) = 1.0_wp
  end subroutine reset_strains

  !> Carry pore pressures from now on, none yet.
  pure subroutine start_water(points)
    type(points_type), intent(inout) :: points

    deallocate (points%steady_pore_pressure, points%pore_pressure, points%pore_state)
    allocate (points%steady_pore_pressure(points%count), points%pore_pressure(points%count), source=0.0_wp)
    allocate (points%pore_state(2, points%count), source=spread([0.0_wp, 1.0_wp], 2, points%count))
  end subroutine start_water

  !> Whether pore pressures are carried.
  pure logical function carries_water(points)
    type(points_type), intent(in) :: points

    carries_water = size(points%pore_pressure) > 0
  end function carries_water

  !> Carry what other points carry.
  pure subroutine carry_as(points, like)
    type(points_type), intent(inout) :: points
    type(points_type), intent(in) :: like

    if (carries_strains(like)) call start_strains(points)
    if (carries_water(like)) call start_water(points)
  end subroutine carry_as

  !> Copy material points: arrays of the same size stay where they are in memory, which an assignment of the whole
  !> does not promise.
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

  !> Copy the values of fields to fields of the same sizes.
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

  !> Allocate surface points of no area.
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

  !> Add displacement, strains and total stress; what is not carried has no columns.
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
