!> Faces at which water leaves in a phase that is too short for it to leave the cells beside them: a node held at p = 0
!> would drain half of its cell at once. The front of the pressure lies within the cell then, and what leaves is what
!> leaves a half space whose pressure p has come at the start of the phase (Carslaw and Jaeger 1959, section 2.4),
!>
!>   q = A (k/(pi M t))^1/2 p,      k = K/gamma_w,  c = k M,
!>
!> with A the share of the node in the face, M the constrained modulus. It counts in phases shorter than 0.1 h^2/c, h
!> the width of the cell; in longer ones such nodes are held. docs/methods/consolidation.md
module qsmpm_face_leak
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_element, only: corner_count, face_area_vector, face_corners, face_count, face_rule, linear_kind, &
    shape_functions
  use qsmpm_material_description, only: material_type, permeability_at
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_model, only: model_type
  implicit none
  private

  public :: face_leaks, front_within, constrained_modulus

  !> Time over h^2/c until which the front lies in the cell, and what leaves is nearer to this than to half of the cell.
  real(wp), parameter :: within_cell = 0.1_wp

contains

  !> What flows out of nodes at drained faces by a unit of pressure, times t^1/2; 0 where a node is to be held
  !> (mesh nodes).
  function face_leaks(model, drained, unit_weight) result(leak)
    type(model_type), intent(in) :: model
    !> Nodes at which water leaves (mesh nodes).
    logical, intent(in) :: drained(:)
    !> Of the water.
    real(wp), intent(in) :: unit_weight
    real(wp) :: leak(model%mesh%node_count)
    logical :: held(model%mesh%node_count)
    integer :: owner(model%mesh%cell_count), p, c, f
    real(wp) :: outflow

    leak = 0.0_wp
    held = .false.
    owner = 0
    do p = 1, model%state%points%count
      owner(model%state%points%cell(p)) = p
    end do
    associate (mesh => model%mesh)
      do c = 1, mesh%cell_count
        if (owner(c) == 0) cycle
        if (.not. model%analysis%materials(model%state%points%material(owner(c)))%permeability(1) > 0.0_wp) cycle
        do f = 1, face_count(mesh%cell_kind(c))
          if (mesh%face_neighbour(f, c) > 0) then
            if (owner(mesh%face_neighbour(f, c)) > 0) cycle
          end if
          associate (ends => mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f)))
            if (.not. all(drained(ends))) cycle
            outflow = outflow_of(model, owner(c), unit_weight)
            held(ends) = held(ends) .or. .not. outflow > 0.0_wp
            leak(ends) = leak(ends) + outflow*corner_areas(model, c, f, size(ends))
          end associate
        end do
      end do
    end associate
    where (held) leak = 0.0_wp
  end function face_leaks

  !> (k/(pi M))^1/2 of a point; 0 where the phase is long, or the soil has no modulus.
  real(wp) function outflow_of(model, p, unit_weight) result(outflow)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    real(wp), intent(in) :: unit_weight
    real(wp) :: permeability

    outflow = 0.0_wp
    associate (soil => model%analysis%materials(model%state%points%material(p)))
      permeability = maxval(permeability_at(soil, model%state%points%initial_position(:, p)))
      if (front_within(soil, permeability/unit_weight, cell_width(model%mesh, model%state%points%cell(p)), &
        model%analysis%phases(model%state%progress%phase)%duration)) &
        outflow = sqrt(permeability/(unit_weight*pi*constrained_modulus(soil)))
    end associate
  end function outflow_of

  !> Whether the front of a pressure that leaves by a face stays in the cell there.
  pure logical function front_within(soil, k, width, time) result(within)
    type(material_type), intent(in) :: soil
    !> Permeability over the weight of water; width of the cell, time of the phase.
    real(wp), intent(in) :: k, width, time

    within = soil%young > 0.0_wp .and. k > 0.0_wp
    if (within) within = k*constrained_modulus(soil)*time < within_cell*width**2
  end function front_within

  !> Stress over strain where nothing moves sideways.
  pure real(wp) function constrained_modulus(soil) result(modulus)
    type(material_type), intent(in) :: soil

    modulus = soil%young*(1.0_wp - soil%poisson)/((1.0_wp + soil%poisson)*(1.0_wp - 2.0_wp*soil%poisson))
  end function constrained_modulus

  !> Shares of the corners in a face (corners).
  pure function corner_areas(model, c, f, n) result(area)
    type(model_type), intent(in) :: model
    !> Number of the cell, and of its face; corners.
    integer, intent(in) :: c, f, n
    real(wp) :: area(n)
    real(wp), allocatable :: place(:, :), weight(:)
    real(wp) :: shape(8), vector(model%mesh%dimension), depth
    integer :: corner(n), kind, q, m
    integer, parameter :: degree = 3

    kind = linear_kind(model%mesh%cell_kind(c))
    corner = face_corners(kind, f)
    m = corner_count(kind)
    area = 0.0_wp
    associate (mesh => model%mesh)
      associate (x => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + m - 1)))
        call face_rule(kind, f, degree, place, weight)
        do q = 1, size(weight)
          call shape_functions(kind, place(:, q), shape(:m))
          call face_area_vector(kind, f, place(:, q), x, vector)
          depth = weight(q)*norm2(vector)
          if (model%analysis%model == axisymmetric) depth = depth*dot_product(x(1, :), shape(:m))
          area = area + depth*shape(corner)
        end do
      end associate
    end associate
  end function corner_areas
end module qsmpm_face_leak
