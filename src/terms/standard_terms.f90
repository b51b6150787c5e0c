!> Terms of every analysis, in the order in which they are added up.
module qsmpm_standard_terms
  use qsmpm_boundary_stabilisation, only: new_boundary_stabilisation
  use qsmpm_contacts, only: new_contacts
  use qsmpm_dead_loads, only: new_dead_loads
  use qsmpm_pore_flow, only: new_pore_flow
  use qsmpm_pressures, only: new_pressures
  use qsmpm_prop_springs, only: new_prop_springs
  use qsmpm_proximal_damping, only: new_proximal_damping
  use qsmpm_soil_points, only: new_soil
  use qsmpm_supports, only: new_supports
  use qsmpm_unloading, only: new_unloading_points
  use qsmpm_term, only: term_type, term_slot_type
  use qsmpm_term_sums, only: share_names
  implicit none
  private

  public :: standard_terms, standard_shares, append_term

contains

  !> Creates all terms, without scratch data.
  subroutine standard_terms(terms)
    type(term_slot_type), allocatable, intent(out) :: terms(:)

    allocate (terms(10))
    call new_soil(terms(1)%term)
    call new_proximal_damping(terms(2)%term)
    call new_boundary_stabilisation(terms(3)%term)
    call new_supports(terms(4)%term)
    call new_dead_loads(terms(5)%term)
    call new_pressures(terms(6)%term)
    call new_unloading_points(terms(7)%term)
    call new_contacts(terms(8)%term)
    call new_prop_springs(terms(9)%term)
    call new_pore_flow(terms(10)%term)
  end subroutine standard_terms

  !> Returns the columns of curves.csv for their shares, each preceded by a comma.
  function standard_shares() result(names)
    character(len=:), allocatable :: names
    type(term_slot_type), allocatable :: terms(:)

    call standard_terms(terms)
    names = share_names(terms)
  end function standard_shares

  !> Appends a term.
  subroutine append_term(terms, term)
    type(term_slot_type), allocatable, intent(inout) :: terms(:)
    class(term_type), intent(in) :: term
    type(term_slot_type), allocatable :: more(:)
    integer :: t

    allocate (more(size(terms) + 1))
    do t = 1, size(terms)
      call move_alloc(terms(t)%term, more(t)%term)
    end do
    allocate (more(size(more))%term, source=term)
    call move_alloc(more, terms)
  end subroutine append_term
end module qsmpm_standard_terms
