!> Words of geotechnics that are no keywords: which card does what they mean, or that nothing here does and what is
!> nearest.
!> The page docs/cannot.md is the same list of what is not there, with reasons.
module qsmpm_help_topics
  use qsmpm_text, only: string_type, split
  implicit none
  private

  public :: topic_text, topics_type, topics

  !> A subject: words that ask for it, in capitals with commas between, and the answer.
  type :: topics_type
    character(len=120) :: words = ''
    character(len=330) :: answer = ''
  end type topics_type

contains

  !> The answer to a word in capitals; empty when there is none. A topic answers when the word holds one of its words.
  pure function topic_text(word) result(text)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: text
    type(topics_type), allocatable :: known(:)
    type(string_type), allocatable :: asked(:)
    integer :: k, i

    text = ''
    allocate (known, source=topics())
    do k = 1, size(known)
      call split(trim(known(k)%words), ',', asked)
      do i = 1, size(asked)
        if (index(word, trim(adjustl(asked(i)%text))) > 0) then
          text = trim(known(k)%answer)
          return
        end if
      end do
    end do
  end function topic_text

  !> All subjects: first what cards do under another name, then what is not there.
  pure function topics() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[there(), missing()])
  end function topics

  !> What cards do.
  pure function there() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('FACTOR OF SAFETY,SAFETY FACTOR,STRENGTH REDUCTION,PHI-C,PHI C', &
        '*PHASE, TYPE=SAFETY with *SAFETY: c and tan(phi) are divided until no equilibrium is found; '// &
        'docs/methods/safety.md'), &
      topics_type('EXCAVAT,DIG,EMBANKMENT,LIFT,FILL,STAGED,STAGE CONSTRUCTION,CONSTRUCTION', &
        '*DEACTIVATE digs a body out, *ACTIVATE builds it, phase by phase; docs/methods/stages.md'), &
      topics_type('GROUNDWATER,PHREATIC,WATER TABLE,PORE PRESSURE,BUOYANCY,DRAWDOWN,FLOOD', &
        '*WATER LEVEL gives the pore pressure at rest below a line, *PRESSURE with LEVEL= presses free '// &
        'water on a surface; docs/methods/water.md'), &
      topics_type('WATER', &
        '*WATER LEVEL for pore water, *PRESSURE with LEVEL= for free water; water that flows is not '// &
        'there: docs/methods/water.md, docs/cannot.md'), &
      topics_type('FOOTING,FOUNDATION,SPUDCAN,PENETRAT,INDENT,PRESS IN', &
        '*PRESCRIBE moves a node set and *MOVING MESH carries the grid with it: input/footing.inp, '// &
        'docs/methods/pushed_sets.md; bodies that touch and slip are not there yet'), &
      topics_type('LAYER,SOIL PROFILE', &
        'a *BODY of its own material a layer; strength by depth by *STRENGTH PROFILE'), &
      topics_type('INITIAL STRESS,GEOSTATIC,AT REST', &
        '*INITIAL, TYPE=K0 with *K0 of the materials, for level ground; else *GRAVITY and *RESET '// &
        'DISPLACEMENTS: docs/methods/initial_stresses.md'), &
      topics_type('ROLLER,BOUNDARY,FIXITY,SUPPORTED', &
        '*FIX holds node sets of the grid, *SUPPORT surfaces that cut it'), &
      topics_type('SURCHARGE,LOAD', &
        '*TRACTION is a dead load on a *SURFACE, *PRESSURE follows its normal, *GRAVITY is weight'), &
      topics_type('CLAY,SAND,TRESCA,VON MISES,MOHR,COULOMB', &
        '*MOHR COULOMB (phi = 0 is Tresca), *DRUCKER PRAGER, *CAM CLAY, *HARDENING SOIL, *USER MATERIAL'), &
      topics_type('UMAT,UDSM,OWN LAW,USER MODEL', &
        '*USER MATERIAL calls a UMAT or a UDSM out of a library that tools/build-umat makes; '// &
        'docs/user_models.md'), &
      topics_type('TRIAXIAL,OEDOMETER,LABORATORY,SIMPLE SHEAR', &
        '*POINT TEST and *POINT STAGE in a deck of their own, run by qsmpm point; docs/point_tests.md'), &
      topics_type('INTERFACE,FRICTION BETWEEN,PILE,SPUD,CONE,CPT,T-BAR,PIPE,SHEET,SLIDING,FOOTING', &
        '*RIGID BODY that the soil may touch by *CONTACT, with friction and adhesion, and *MOVE in a phase: '// &
        'docs/methods/contact.md; what is not there yet: docs/cannot.md'), &
      topics_type('STEP,INCREMENT,CONVERGENCE', &
        '*CONTROLS inside a *PHASE'), &
      topics_type('OUTPUT,PLOT,PICTURE,VTK,HDF5', &
        '*FIELD says how often pictures are written, *HISTORY which curves'), &
      topics_type('AXISYMMETR,PLANE STRAIN,SYMMETRY', &
        '*MODEL, TYPE=; AUTO finds the smallest model: docs/scene.md')])
  end function there

  !> What nothing here does.
  pure function missing() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('ANCHOR,GEOGRID,GEOTEXTILE,NAIL,TRUSS,STRUT,BEAM,PLATE,SHELL,LINING,WALL', &
        'structural elements are not there; nearest: a *BODY of stiff *ELASTIC a few cells thick, or '// &
        '*TRACTION in place of the force of an anchor: docs/cannot.md'), &
      topics_type('SEEPAGE,CONSOLIDAT,DARCY,PERMEAB,FLOW', &
        'water that flows is not there; nearest: *WATER LEVEL for its pressure, *UNDRAINED and *DRAIN '// &
        'STATE for soil before and after consolidation: docs/cannot.md'), &
      topics_type('EARTHQUAKE,DYNAMIC,WAVE,INERTIA,VELOCITY,IMPACT,SEISMIC', &
        'there is no inertia: every step is an equilibrium; nearest: a horizontal share of *GRAVITY '// &
        '(pseudo-static): docs/cannot.md'), &
      topics_type('CREEP,VISC,RATE OF,TIME DEPEND', &
        'no law here flows in time; nearest: a *USER MATERIAL, which gets TIME= of the *PHASE: '// &
        'docs/cannot.md'), &
      topics_type('HEAT,THERMAL,TEMPERATURE,FREEZ,UNSATURAT,SUCTION,GAS', &
        'temperature, suction and gas are not there: docs/cannot.md'), &
      topics_type('PARALLEL,MPI,GPU,CLUSTER', &
        'threads of one machine: --threads N; more machines are not there: docs/performance.md')])
  end function missing
end module qsmpm_help_topics
