!> The consistent tangent of a yielding soil as the model builder sets it: it holds a share of the elastic one that keeps
!> it regular, and no more. Where a whole mechanism yields that share is most of its stiffness: with 1e-3 the slope of
!> docs/methods/limit_loads.md took three times the iterations.
module test_model_tangent
  use law_trials, only: random_batch, difference_error
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, tangent_consistent
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_model_tangent

contains

  !> All checks.
  subroutine collect_model_tangent(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: error

    call tests%start('model_tangent')
    error = tangent_error('')
    call tests%close('the tangent of an elastic material is the derivative of its stress', error, 0.0_wp, 1.0e-7_wp)
    error = tangent_error('*MOHR COULOMB|1, 25, 25|')
    call tests%check('that of a yielding soil but for a share of the elastic one below 2e-5', error <= 2.0e-5_wp)
    call tests%check('which is not without one', error >= 2.0e-6_wp)
  end subroutine collect_model_tangent

  !> Largest distance of the tangent to differences of the stress, over its largest entry: points strained by 4 %.
  real(wp) function tangent_error(strength) result(error)
    !> Cards of the strength.
    character(len=*), intent(in) :: strength
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    class(model_type), allocatable :: model
    type(error_type), allocatable :: failure
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    integer :: compared

    allocate (analysis, model)
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 1, 2|Y, 0, 1, 2|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|200, 0.33|'//strength// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), &
      analysis, messages, failure)
    if (.not. allocated(failure)) call build_model(analysis, model, failure)
    if (allocated(failure)) error stop 'the deck of the test is not good'
    associate (law => model%laws(1)%law)
      call random_batch(law, 400, 0.04_wp, 1.0_wp, batch)
      call law%update(batch, tangent_consistent)
      allocate (tangent, source=batch%tangent)
      call difference_error(law, batch, tangent, error, compared)
    end associate
    if (compared == 0) error = huge(error)
  end function tangent_error
end module test_model_tangent
