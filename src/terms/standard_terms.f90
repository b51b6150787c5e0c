!> Terms of every analysis, in the order in which they are added up.
module qsmpm_standard_terms
  use qsmpm_boundary_stabilisation, only: stabilisation_type
  use qsmpm_contacts, only: contacts_type
  use qsmpm_dead_loads, only: dead_loads_type
  use qsmpm_pore_flow, only: pore_flow_type
  use qsmpm_pressures, only: pressures_type
  use qsmpm_prop_springs, only: prop_springs_type
  use qsmpm_proximal_damping, only: damping_type
  use qsmpm_soil_points, only: soil_type
  use qsmpm_supports, only: supports_type
  use qsmpm_unloading, only: unloading_points_type
  use qsmpm_term, only: term_type, term_slot_type, role_external, role_numerical
  use qsmpm_term_share, only: damping_share, stabilisation_share
  use qsmpm_term_sums, only: share_names
  implicit none
  private

  public :: standard_terms, standard_shares, append_term

contains

  !> Creates all terms, without scratch data.
  subroutine standard_terms(terms)
    type(term_slot_type), allocatable, intent(out) :: terms(:)

    allocate (terms(10))
    allocate (terms(1)%term, source=soil_type(name='internal force'))
    allocate (terms(2)%term, source=damping_type(name='damping force', role=role_numerical, &
      share_name=damping_share, transient=.true.))
    allocate (terms(3)%term, source=stabilisation_type(name='force of the stabilisation', role=role_numerical, &
      share_name=stabilisation_share))
    allocate (terms(4)%term, source=supports_type(name='force of the supports', anchors=.true.))
    allocate (terms(5)%term, source=dead_loads_type(name='load', role=role_external))
    allocate (terms(6)%term, source=pressures_type(name='load of the pressures', role=role_external))
    allocate (terms(7)%term, source=unloading_points_type(name='force of the bodies taken out', role=role_external))
    allocate (terms(8)%term, source=contacts_type(name='force of the contacts', role=role_external, of_bodies=.true., &
      anchors=.true.))
    allocate (terms(9)%term, source=prop_springs_type(name='force of the props'))
    allocate (terms(10)%term, source=pore_flow_type(name='flow of the pore water'))
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
