!> Drained faces: decay of the nodal pressure at a face while water drains from the adjacent cells. A node fixed at
!> p = 0 would drain slightly more than a quarter of its cell at once, however short the time.
!>
!> Let a half space of cells of height h, with linear pressures and corresponding strains, drain from a pressure J
!> applied instantaneously. The outflow is correct, q = J (k/(pi M t))^1/2 (Carslaw and Jaeger 1959, section 2.4), if
!> the node at the face has
!>
!>   p = J erfc (12 c t/h^2)^1/2,      k = K/gamma_w,  c = k M,
!>
!> J (1/s - 1/(s (1 + s h^2/(12 c))^1/2)) in the Laplace domain. As J grows in increments, p is the sum of the
!> remainders of all increments. J is the pressure without drainage: p plus its reduction by the loss w of the node,
!>
!>   dJ = dp + 12^1/2 M/(h A) dw,      erfc x^1/2 = 1/pi int exp(-x (1 + exp 2z)) sech z dz = sum w_i exp(-r_i x),
!>
!> A being the share of the node in the face, M the constrained modulus. One variable for each term of the sum stores
!> the history of loads and times. The outflow is linear in p, and tends to p = 0 for long steps, to w = 0 for short
!> ones. docs/methods/consolidation.md
module qsmpm_face_leak
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_confined_modulus, only: confined_modulus
  use qsmpm_element, only: corner_count, face_area_vector, face_corners, face_count, face_rule, linear_kind, &
    shape_functions
  use qsmpm_material_description, only: material_type, permeability_at
  use qsmpm_mesh_measure, only: cell_volume, cell_width
  use qsmpm_model, only: model_type
  use qsmpm_permeability_law, only: permeability_ratio
  implicit none
  private

  public :: face_layers_type, find_layers, front_within, constrained_modulus

  !> Name of the stored history variables.
  character(len=*), parameter, public :: layer_name = 'excess pressure of layers at faces'
  !> Time relative to h^2/c up to which the drainage front is within the cell.
  real(wp), parameter :: within_cell = 0.1_wp
  !> Number of terms of the sum, and their spacing in z; the first includes the tail below it. The error of erf is at
  !> most 5 % from c t/h^2 = 3e-5 on.
  integer, parameter, public :: terms_of_layer = 6
  real(wp), parameter :: spacing = 1.4_wp
  real(wp), parameter :: place(terms_of_layer) = spacing*[-1, 0, 1, 2, 3, 4], &
    share(2:terms_of_layer) = spacing/(pi*cosh(place(2:))), weight(terms_of_layer) = [1.0_wp - sum(share), share], &
    rate(terms_of_layer) = 1.0_wp + exp(2.0_wp*place)

  !> Nodes of drained faces in a step.
  type :: face_layers_type
    !> Loss per unit drop of pressure, sum A h/(12^1/2 M), 0 at other nodes; 12 c/h^2 (nodes).
    real(wp), allocatable :: capacity(:), pace(:)
    !> Variables of the terms minus p at the start of the step (terms, nodes).
    real(wp), allocatable :: beyond(:, :)
    !> Remainder at the end of the step of a unit of J that grows linearly over it, of a unit of p at its start, and of
    !> the variables beyond p (nodes).
    real(wp), allocatable :: follows(:), left(:), past(:)
    !> Remainder of each term of its initial value, and of a linear increase (terms, nodes).
    real(wp), allocatable :: decay(:, :), comes(:, :)
  contains
    procedure :: set_time
    procedure :: outflow
    procedure :: beyond_after
  end type face_layers_type

contains

  !> Finds the nodes of drained faces and the capacities of their cells.
  subroutine find_layers(model, pressure, drained, unit_weight, only_brief, layers)
    type(model_type), intent(in) :: model
    !> Excess pressure of the water, and nodes at which it drains (mesh nodes).
    real(wp), intent(in) :: pressure(:)
    logical, intent(in) :: drained(:)
    !> Unit weight of the water.
    real(wp), intent(in) :: unit_weight
    !> Restricts the result to faces whose drainage front stays within the cell during the phase.
    logical, intent(in) :: only_brief
    type(face_layers_type), intent(out) :: layers
    logical :: held(model%mesh%node_count)
    real(wp) :: conductance(model%mesh%node_count), k, width, area(8), corner_area(8), modulus
    integer :: owner(model%mesh%cell_count), p, c, f, n

    layers%capacity = [(0.0_wp, n=1, size(held))]
    conductance = 0.0_wp
    held = .false.
    owner = 0
    associate (mesh => model%mesh, points => model%state%points)
      owner(points%cell(:points%count)) = [(p, p=1, points%count)]
      do c = 1, mesh%cell_count
        if (owner(c) == 0) cycle
        associate (soil => model%analysis%materials(points%material(owner(c))), &
            seconds => model%analysis%phases(model%state%progress%phase)%duration)
          if (.not. soil%permeability(1) > 0.0_wp) cycle
          k = maxval(permeability_at(soil, points%initial_position(:, owner(c))))/unit_weight &
            *permeability_ratio(soil%permeability_law, points%volume(owner(c))/points%initial_volume(owner(c)))
          do f = 1, face_count(mesh%cell_kind(c))
            if (mesh%face_neighbour(f, c) > 0) then
              if (owner(mesh%face_neighbour(f, c)) > 0) cycle
            end if
            associate (ends => mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f)))
              if (.not. all(drained(ends))) cycle
              modulus = confined_modulus(model, owner(c), sum(pressure(ends)))
              if (modulus > 0.0_wp .and. (.not. only_brief .or. &
                front_within(soil, k, cell_width(mesh, c), seconds))) then
                n = size(ends)
                call find_areas(model, c, f, area(:n), corner_area(:n))
                width = cell_volume(mesh, c)/sum(area(:n))
                if (corner_count(mesh%cell_kind(c)) == mesh%dimension + 1) width = mesh%dimension*width
                layers%capacity(ends) = layers%capacity(ends) + corner_area(:n)*width/(sqrt(12.0_wp)*modulus)
                conductance(ends) = conductance(ends) + corner_area(:n)*k/width
              else
                held(ends) = .true.
              end if
            end associate
          end do
        end associate
      end do
    end associate
    where (held) layers%capacity = 0.0_wp
    layers%pace = sqrt(12.0_wp)*conductance/max(layers%capacity, tiny(1.0_wp))
    layers%capacity = 0.5_wp*(layers%capacity + capacities(model, pressure, layers%capacity > 0.0_wp))
    allocate (layers%beyond(terms_of_layer, size(held)), source=0.0_wp)
    call layers%set_time(0.0_wp)
  end subroutine find_layers

  !> Returns the loss of the nodes at faces for a unit drop of pressure at all of them and, as nothing flows within, a
  !> rise of 2 - 3^1/2 at those behind; in a row of nodes it is A h/(12^1/2 M) (mesh nodes).
  function capacities(model, pressure, at_face) result(capacity)
    type(model_type), intent(in) :: model
    !> Excess pressure of the water (mesh nodes).
    real(wp), intent(in) :: pressure(:)
    logical, intent(in) :: at_face(:)
    real(wp) :: capacity(size(at_face)), shape(8), modulus
    real(wp), parameter :: rise = 2.0_wp - sqrt(3.0_wp)
    integer :: p, n

    capacity = 0.0_wp
    associate (mesh => model%mesh, points => model%state%points)
      do p = 1, points%count
        associate (c => points%cell(p))
          if (.not. model%analysis%materials(points%material(p))%permeability(1) > 0.0_wp) cycle
          n = corner_count(mesh%cell_kind(c))
          associate (node => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + n - 1))
            if (.not. any(at_face(node))) cycle
            modulus = confined_modulus(model, p, sum(pressure(node)))
            if (.not. modulus > 0.0_wp) cycle
            call shape_functions(linear_kind(mesh%cell_kind(c)), points%local(:, p), shape(:n))
            capacity(node) = capacity(node) + points%volume(p)*shape(:n) &
              *sum(merge(shape(:n), -rise*shape(:n), at_face(node)))/modulus
          end associate
        end associate
      end do
    end associate
    where (.not. at_face) capacity = 0.0_wp
  end function capacities

  !> Computes the remainders at the end of a step of given duration.
  pure subroutine set_time(self, duration)
    class(face_layers_type), intent(inout) :: self
    real(wp), intent(in) :: duration
    !> Below this value 1 - exp(-x) is replaced by x (1 - x/2).
    real(wp), parameter :: brief = 1.0e-6_wp
    real(wp) :: x(terms_of_layer)
    integer :: a

    associate (n => size(self%capacity))
      self%follows = [(1.0_wp, a=1, n)]
      self%left = self%follows
      self%past = self%follows
      self%decay = spread(self%follows, 1, terms_of_layer)
      self%comes = self%decay
      do a = 1, n
        if (.not. self%capacity(a) > 0.0_wp) cycle
        x = rate*self%pace(a)*duration
        self%decay(:, a) = exp(-x)
        self%comes(:, a) = 1.0_wp - 0.5_wp*x
        where (x > brief) self%comes(:, a) = (1.0_wp - self%decay(:, a))/x
        self%follows(a) = sum(weight*self%comes(:, a))
        self%left(a) = sum(weight*self%decay(:, a))
        self%past(a) = sum(weight*self%decay(:, a)*self%beyond(:, a))
      end do
    end associate
  end subroutine set_time

  !> Returns the loss w of a node in the step from its pressures relative to the outside at the start and at the end,
  !> and its derivative with respect to the latter.
  pure subroutine outflow(self, a, start, final, flow, slope)
    class(face_layers_type), intent(in) :: self
    !> Number of the node.
    integer, intent(in) :: a
    real(wp), intent(in) :: start, final
    real(wp), intent(out) :: flow, slope

    slope = self%capacity(a)*(1.0_wp/self%follows(a) - 1.0_wp)
    flow = slope*final + self%capacity(a)*(start - (self%left(a)*start + self%past(a))/self%follows(a))
  end subroutine outflow

  !> Returns the variables of the terms minus the pressure at the end of the step (terms).
  pure function beyond_after(self, a, start, final) result(beyond)
    class(face_layers_type), intent(in) :: self
    integer, intent(in) :: a
    real(wp), intent(in) :: start, final
    real(wp) :: beyond(terms_of_layer)

    beyond = self%decay(:, a)*(start + self%beyond(:, a)) &
      + self%comes(:, a)*(final - self%left(a)*start - self%past(a))/self%follows(a) - final
  end function beyond_after

  !> Checks whether the drainage front of a face stays within its cell.
  pure logical function front_within(soil, k, width, time) result(within)
    type(material_type), intent(in) :: soil
    !> Permeability over unit weight of water; width of the cell, duration of the phase.
    real(wp), intent(in) :: k, width, time

    within = soil%young > 0.0_wp .and. k > 0.0_wp
    if (within) within = time < within_cell*width**2/(k*constrained_modulus(soil))
  end function front_within

  !> Constrained modulus of elastic soil: stress over strain without lateral strain.
  pure real(wp) function constrained_modulus(soil) result(modulus)
    type(material_type), intent(in) :: soil

    modulus = soil%young*(1.0_wp - soil%poisson)/((1.0_wp + soil%poisson)*(1.0_wp - 2.0_wp*soil%poisson))
  end function constrained_modulus

  !> Integrates the corner shape functions over a face, in the plane and, in axisymmetry, weighted by the radius
  !> (corners).
  pure subroutine find_areas(model, c, f, area, whole)
    type(model_type), intent(in) :: model
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f
    real(wp), intent(out) :: area(:), whole(:)
    real(wp), allocatable :: place(:, :), weight(:)
    real(wp) :: shape(8), vector(model%mesh%dimension), depth, radius
    integer :: corner(size(area)), kind, q, m
    integer, parameter :: degree = 3

    kind = linear_kind(model%mesh%cell_kind(c))
    corner = face_corners(kind, f)
    m = corner_count(kind)
    area = 0.0_wp
    whole = 0.0_wp
    associate (mesh => model%mesh)
      associate (x => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + m - 1)))
        call face_rule(kind, f, degree, place, weight)
        do q = 1, size(weight)
          call shape_functions(kind, place(:, q), shape(:m))
          call face_area_vector(kind, f, place(:, q), x, vector)
          depth = weight(q)*norm2(vector)
          radius = 1.0_wp
          if (model%analysis%model == axisymmetric) radius = dot_product(x(1, :), shape(:m))
          area = area + depth*shape(corner)
          whole = whole + radius*depth*shape(corner)
        end do
      end associate
    end associate
  end subroutine find_areas
end module qsmpm_face_leak
