!> Material points and surface points of a model: bodies and surfaces of the deck on the mesh.
module qsmpm_model_bodies
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: body_type, body_box, body_polygon, body_region, basis_fem, &
    axisymmetric, three_dimensional, select_box, select_segment, select_mesh
  use qsmpm_element, only: shape_functions
  use qsmpm_fault_list, only: fault_list_type, add_fault
  use qsmpm_model, only: model_type
  use qsmpm_points, only: allocate_points, allocate_carried, carried_type
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body
  use qsmpm_surface_seeding, only: seed_faces, seed_segment
  use qsmpm_mesh_sets, only: faces_in_box, find_set
  use qsmpm_mesh_measure, only: interpolate, cell_coordinates
  use qsmpm_cell_measure, only: cell_volumes
  use qsmpm_carried_basis, only: nearest_point
  implicit none
  private

  public :: make_points, make_surfaces, place_seeds

  !> Cells may be filled beyond one by rounding only; more means that bodies overlap.
  real(wp), parameter :: overfull = 1.0_wp + 1.0e-6_wp

contains

  !> Seed all bodies.
  subroutine make_points(model, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    integer :: b, before

    do b = 1, size(model%analysis%bodies)
      associate (body => model%analysis%bodies(b))
        before = list%count
        call seed_body(model%mesh, model%analysis%model == axisymmetric, shape_of(model, body, faults), b, &
          body%points_per_element, model%analysis%method%basis == basis_fem, list, error)
        if (allocated(error)) then
          call add_fault(faults, body%where, '*BODY', error%message)
        else if (list%count == before) then
          call add_fault(faults, body%where, '*BODY', "body '"//body%name//"' lies outside the mesh")
        end if
      end associate
    end do
    if (faults%count > 0) return
    call points_from_seeds(model, list)
    call check_overlap(model, faults)
  end subroutine make_points

  !> Bounds of a body as the seeding wants them.
  function shape_of(model, body, faults) result(shape)
    !> The model.
    type(model_type), intent(in) :: model
    !> Number of the body.
    type(body_type), intent(in) :: body
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    type(body_shape_type) :: shape
    integer :: s

    select case (body%kind)
    case (body_polygon)
      allocate (shape%outline, source=body%polygon)
    case (body_box)
      allocate (shape%outline(2, 4))
      shape%outline(:, 1) = body%box(:2, 1)
      shape%outline(:, 2) = [body%box(1, 2), body%box(2, 1)]
      shape%outline(:, 3) = body%box(:2, 2)
      shape%outline(:, 4) = [body%box(1, 1), body%box(2, 2)]
      if (model%analysis%model == three_dimensional) then
        shape%low = body%box(3, 1)
        shape%high = body%box(3, 2)
      end if
    case (body_region)
      allocate (shape%region(model%mesh%cell_count), source=.false.)
      s = find_set(model%mesh%cell_sets, body%region)
      if (s > 0) then
        shape%region(model%mesh%cell_sets(s)%items) = .true.
      else
        call add_fault(faults, body%where, '*BODY', "there is no element set '"//body%region//"'")
      end if
    end select
  end function shape_of

  !> Material points from the seeds: unstressed, at their places.
  subroutine points_from_seeds(model, list)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The seeds.
    type(seed_list_type), intent(in) :: list
    integer :: p, states, m
    real(wp), allocatable :: zero(:)
    real(wp) :: area

    states = 0
    do m = 1, size(model%laws)
      states = max(states, model%laws(m)%law%state_count)
    end do
    call allocate_points(model%state%points, model%mesh%dimension, list%count, &
      merge(4, 6, model%mesh%dimension == 2), states)
    associate (points => model%state%points)
      call place_seeds(model, list, points)
      points%volume = list%volume(:list%count)
      points%initial_volume = points%volume
      points%body = list%body(:list%count)
      allocate (zero(size(points%stress, 1)), source=0.0_wp)
      do p = 1, points%count
        m = material_number(model, points%body(p))
        points%material(p) = m
        area = points%volume(p)
        if (model%analysis%model == axisymmetric) area = area/points%position(1, p)
        points%half_size(:, p) = half_of_cell(model, points%cell(p), area)
        points%weight(p) = model%analysis%materials(m)%unit_weight*points%volume(p)
        associate (law => model%laws(m)%law)
          call law%start(zero, points%state(:law%state_count, p))
        end associate
      end do
    end associate
  end subroutine points_from_seeds

  !> Half lengths of a box with the shape of a cell and a point's volume, in the plane its area.
  function half_of_cell(model, cell, volume) result(half)
    !> The model.
    type(model_type), intent(in) :: model
    !> Cell of the point, and its volume or area.
    integer, intent(in) :: cell
    real(wp), intent(in) :: volume
    real(wp) :: half(model%mesh%dimension)
    real(wp), allocatable :: x(:, :)

    allocate (x, source=cell_coordinates(model%mesh, cell))
    half = 0.5_wp*(maxval(x, dim=2) - minval(x, dim=2))
    half = half*(volume/product(2.0_wp*half))**(1.0_wp/size(half))
  end function half_of_cell

  !> Number of a body's material; the deck has checked that it exists.
  pure function material_number(model, body) result(number)
    !> The model.
    type(model_type), intent(in) :: model
    !> Number of the body.
    integer, intent(in) :: body
    integer :: number
    integer :: m

    number = 1
    do m = 1, size(model%analysis%materials)
      if (model%analysis%materials(m)%name == model%analysis%bodies(body)%material) number = m
    end do
  end function material_number

  !> Cells, local coordinates and positions of seeds.
  pure subroutine place_seeds(model, list, carried)
    !> The model.
    type(model_type), intent(in) :: model
    !> The seeds.
    type(seed_list_type), intent(in) :: list
    !> What rides on the mesh.
    class(carried_type), intent(inout) :: carried
    real(wp) :: functions(20)
    integer :: i, n

    do i = 1, list%count
      carried%cell(i) = list%cell(i)
      carried%local(:, i) = list%local(:, i)
      n = model%mesh%cell_first(list%cell(i) + 1) - model%mesh%cell_first(list%cell(i))
      call shape_functions(model%mesh%cell_kind(list%cell(i)), list%local(:, i), functions(:n))
      carried%position(:, i) = interpolate(model%mesh, list%cell(i), functions(:n), model%mesh%coordinates)
    end do
    carried%initial_position = carried%position
  end subroutine place_seeds

  !> No cell may hold more than its volume at the start.
  subroutine check_overlap(model, faults)
    !> The model.
    type(model_type), intent(in) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    real(wp) :: volumes(model%mesh%cell_count), held(model%mesh%cell_count)
    integer :: p, last

    call cell_volumes(model%mesh, model%analysis%model == axisymmetric, volumes)
    held = 0.0_wp
    do p = 1, model%state%points%count
      held(model%state%points%cell(p)) = held(model%state%points%cell(p)) + model%state%points%volume(p)
    end do
    last = size(model%analysis%bodies)
    if (any(held > overfull*volumes)) call add_fault(faults, model%analysis%bodies(last)%where, '*BODY', &
      'bodies overlap: an element holds more material than its volume')
  end subroutine check_overlap

  !> Surface points of all surfaces, and the points that carry tractions in the paper's way.
  subroutine make_surfaces(model, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    type(seed_list_type) :: list
    logical :: occupied(model%mesh%cell_count)
    integer, allocatable :: faces(:, :)
    integer :: s, k, before

    occupied = .false.
    occupied(model%state%points%cell) = .true.
    do s = 1, size(model%analysis%surfaces)
      associate (surface => model%analysis%surfaces(s))
        before = list%count
        select case (surface%selection)
        case (select_box)
          call faces_in_box(model%mesh, surface%box, faces)
          call seed_faces(model%mesh, model%analysis%model == axisymmetric, occupied, faces, s, list)
        case (select_segment)
          if (model%mesh%dimension == 3) then
            call add_fault(faults, surface%where, '*SURFACE', 'TYPE=SEGMENT is for plane models')
            cycle
          end if
          do k = 1, size(surface%segments, 2)
            call seed_segment(model%mesh, model%analysis%model == axisymmetric, occupied, &
              surface%segments(:, k), s, list)
          end do
        case (select_mesh)
          call mesh_faces(model, surface%name, faces)
          call seed_faces(model%mesh, model%analysis%model == axisymmetric, occupied, faces, s, list)
        end select
        if (list%count == before) call add_fault(faults, surface%where, '*SURFACE', &
          "surface '"//surface%name//"' touches no element that holds material")
      end associate
    end do
    if (faults%count > 0) return
    call allocate_carried(model%state%surface, model%mesh%dimension, list%count)
    allocate (model%state%surface%surface(list%count), model%state%surface%area(list%count))
    if (list%count > 0) then
      call place_seeds(model, list, model%state%surface)
      model%state%surface%surface = list%body(:list%count)
      model%state%surface%area = list%volume(:list%count)
    end if
    call choose_carrying_points(model)
  end subroutine make_surfaces

  !> Faces of a surface named by the mesh.
  subroutine mesh_faces(model, name, faces)
    !> The model.
    type(model_type), intent(in) :: model
    !> Name.
    character(len=*), intent(in) :: name
    !> Cell and local face, (2,n).
    integer, allocatable, intent(out) :: faces(:, :)
    integer :: s

    allocate (faces(2, 0))
    do s = 1, size(model%mesh%face_sets)
      if (model%mesh%face_sets(s)%name == name) faces = model%mesh%face_sets(s)%faces
    end do
  end subroutine mesh_faces

  !> The paper's way (section 3.1): each piece of surface hands its area to the nearest material point.
  subroutine choose_carrying_points(model)
    !> The model.
    type(model_type), intent(inout) :: model
    integer :: i

    allocate (model%carrying_point(model%state%surface%count), model%carrying_surface(model%state%surface%count))
    allocate (model%carrying_area(model%state%surface%count))
    do i = 1, model%state%surface%count
      model%carrying_point(i) = nearest_point(model%state%points, model%state%surface%position(:, i))
      model%carrying_surface(i) = model%state%surface%surface(i)
      model%carrying_area(i) = model%state%surface%area(i)
    end do
  end subroutine choose_carrying_points
end module qsmpm_model_bodies
