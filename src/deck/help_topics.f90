!> Help topics: geotechnical terms and keywords of other programs that are not keywords here, with the keyword that
!> provides them, or the statement that it is not available and the closest alternative. docs/cannot.md lists what is
!> not available with reasons.
!>
!> Renamed words of decks and results: reported by the reader, which names the new word in addition to the old one, by
!> `qsmpm help renamed` and docs/renamed.md, and used by tools/convert-deck, which requests them from the program.
module qsmpm_help_topics
  use qsmpm_text, only: string_type, replaced, split
  implicit none
  private

  public :: topic_text, is_topic, topics_type, topics, renamed, renamed_text

  !> A topic: terms in capitals separated by commas, and the answer.
  type :: topics_type
    character(len=160) :: words = ''
    character(len=330) :: answer = ''
  end type topics_type

  !> Text after the new word.
  character(len=*), parameter, public :: by_converter = ' (tools/convert-deck DECK writes the new words)'

  integer, parameter :: n = 24
  character(len=*), parameter :: keyword = 'keyword', curves = 'curves.csv'

  type :: renamed_type
    !> `keyword`, the keyword to which a parameter belongs (its current name), or the file of a result.
    character(len=n) :: where
    character(len=n) :: old, new
  end type renamed_type

  type(renamed_type), parameter :: words(*) = [ &
    renamed_type(keyword, 'LOCKING CURE', 'VOLUMETRIC LOCKING'), &
    renamed_type(keyword, 'HOLD TEST', 'CONSTANT LOAD TEST'), &
    renamed_type('CONTROLS', 'FEW ITERATIONS', 'DESIRED MIN ITERATIONS'), &
    renamed_type('CONTROLS', 'MANY ITERATIONS', 'DESIRED MAX ITERATIONS'), &
    renamed_type('CONTROLS', 'LARGEST MOVE', 'MAX DISPLACEMENT'), &
    renamed_type('CONTROLS', 'MAX HOLDS', 'MAX REEQUILIBRATIONS'), &
    renamed_type('CONTROLS', 'HOLD FADE', 'STABILISATION FADE'), &
    renamed_type('CONTROLS', 'PROXIMAL', 'DAMPING'), &
    renamed_type('CONTROLS', 'DRAG SHARE', 'DAMPING SHARE'), &
    renamed_type('STRENGTH PROFILE', 'TYPE=FIELD', '*FIELD OF VALUES'), &
    renamed_type(curves, 'drag_share', 'damping_share')]

contains

  !> Returns the answer to a word in capitals, empty if there is none. Exact terms of topics take precedence over
  !> partial matches.
  pure function topic_text(word) result(text)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: text
    type(topics_type), allocatable :: known(:)
    integer :: k

    allocate (known, source=topics())
    k = topic_of(known, word, .true.)
    if (k == 0) k = topic_of(known, word, .false.)
    if (k == 0) k = topic_of(known, replaced(word, '-', ' '), .false.)
    text = ''
    if (k > 0) text = trim(known(k)%answer)
  end function topic_text

  !> Checks whether a word in capitals is itself a term of a topic.
  pure logical function is_topic(word)
    character(len=*), intent(in) :: word

    is_topic = topic_of(topics(), word, .true.) > 0
  end function is_topic

  !> Returns the number of the first topic that matches a word, 0 for none. A word matches a term if one of its parts
  !> begins with it; terms of up to three letters must match entirely.
  pure integer function topic_of(known, word, whole) result(found)
    type(topics_type), intent(in) :: known(:)
    character(len=*), intent(in) :: word
    !> The word must equal a term, not only contain one.
    logical, intent(in) :: whole
    type(string_type), allocatable :: asked(:)
    integer :: i

    do found = 1, size(known)
      call split(trim(known(found)%words), ',', asked)
      do i = 1, size(asked)
        if (whole .and. word == asked(i)%text) return
        if (.not. whole .and. holds(' '//word//' ', trim(asked(i)%text))) return
      end do
    end do
    found = 0
  end function topic_of

  !> Checks whether a part of a word between blanks begins with a term, or equals it if that is short.
  pure logical function holds(word, part)
    character(len=*), intent(in) :: word, part

    if (len(part) <= 3) then
      holds = index(word, ' '//part//' ') > 0
    else
      holds = index(word, ' '//part) > 0
    end if
  end function holds

  !> Returns all topics: first those available under another name, then those not available.
  pure function topics() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[workflow(), soil(), other_programs(), tools(), missing()])
  end function topics

  !> Topics of ground, water and structures.
  pure function workflow() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('FACTOR OF SAFETY,SAFETY FACTOR,SLOPE STABILITY,STRENGTH REDUCTION,PHI-C,PHI C,FOS,SRF', &
        '*PHASE, TYPE=SAFETY with *SAFETY: c and tan(phi) are divided until no equilibrium is found; '// &
        'docs/methods/safety.md'), &
      topics_type('LIFT,FILL', &
        '*ACTIVATE of one *BODY a lift, a *PHASE each: with FILL=LEVEL it reaches down to the ground as that has '// &
        'settled; docs/methods/stages.md'), &
      topics_type('SLOPE,DAM,LEVEE,DIKE,BANK', &
        'a *BODY, SHAPE=POLYGON that cuts the cells of a *GRID as it likes: docs/tutorial/4_slope.md, '// &
        'input/dam_drawdown.inp; its factor of safety is *PHASE, TYPE=SAFETY'), &
      topics_type('EXCAVAT,DIG,DIGGING,PIT,CUT,TRENCH,EMBANKMENT,STAGE,CONSTRUCTION,MODEL CHANGE', &
        '*DEACTIVATE digs a body out, *ACTIVATE builds it, phase by phase; docs/methods/stages.md'), &
      topics_type('DEWATER,DRAWDOWN,FLOOD,PUMP,LOWERING,TIDE', &
        '*WATER LEVEL in a later *PHASE: the level moves evenly over the phase, the water behind it in the TIME of '// &
        'the phase with TYPE=SEEPAGE, FLOW=TRANSIENT; docs/methods/water.md, docs/methods/seepage.md'), &
      topics_type('GROUNDWATER,PHREATIC,WATER TABLE,PORE,BUOYANCY,UPLIFT,SUBMERGED,HYDROSTATIC', &
        '*WATER LEVEL gives the pore pressure at rest below a line, *PRESSURE with LEVEL= presses free '// &
        'water on a surface; docs/methods/water.md'), &
      topics_type('WATER', &
        '*WATER LEVEL for pore water, TYPE=SEEPAGE where it flows, *PRESSURE with LEVEL= for free water: '// &
        'docs/methods/water.md, docs/methods/seepage.md'), &
      topics_type('FOOTING,FOUNDATION,RAFT,SPUDCAN,PENETRAT,INDENT,PRESS IN,BEARING CAPACITY', &
        'a *RIGID BODY pressed in by *MOVE, with *CONTACT that slips and lets go: docs/methods/contact.md; or '// &
        '*PRESCRIBE moves a node set and *MOVING MESH carries the grid with it: docs/methods/pushed_sets.md'), &
      topics_type('LAYER,SOIL PROFILE,STRATUM,BOREHOLE', &
        'a *BODY of its own material a layer; strength by depth by *STRENGTH PROFILE'), &
      topics_type('INITIAL STRESS,GEOSTATIC,AT REST,K0 PROCEDURE,INITIAL CONDITION,GRAVITY LOADING', &
        '*INITIAL, TYPE=K0 with *K0 of the materials, for level ground; else *GRAVITY and *RESET '// &
        'DISPLACEMENTS: docs/methods/initial_stresses.md'), &
      topics_type('VOLUME LOSS,GROUND LOSS,CONTRACTION,TUNNEL,TBM,SHIELD,CONVERGENCE OF A TUNNEL,TROUGH,PECK,CAVITY', &
        '*CONTRACTION shrinks the outline of a cavity by a volume loss over a phase, *DEACTIVATE takes the soil of '// &
        'a tunnel out; a lining that bends is not there: input/tunnel.inp, docs/methods/supports.md'), &
      topics_type('STRUT,PROP,SPRING,TRUSS,BRACING,PRESTRESS,TIE', &
        '*PROP draws a spring between two places, *INSTALL puts it in place and jacks it, *REMOVE takes it out: '// &
        'input/pit_propped.inp, docs/methods/supports.md'), &
      topics_type('SETTLEMENT,HEAVE,DEFLECTION,MONITORING', &
        '*HISTORY, QUANTITY=DISPLACEMENT at a place; *RESET DISPLACEMENTS lets it count from a phase on'), &
      topics_type('RUN-OUT,RUN OUT,RUNOUT,LANDSLIDE,DEBRIS,SLIDE,SLIP SURFACE,AVALANCHE,MUDFLOW', &
        'a *PHASE that goes on past the limit load, or *SAFETY, RUNOUT=; *HISTORY, QUANTITY=RUNOUT tells how far'), &
      topics_type('LIMIT EQUILIBRIUM,LEM,BISHOP,SPENCER,JANBU,SLICES', &
        'there are no slices: *PHASE, TYPE=SAFETY finds the slip surface by itself'), &
      topics_type('PARTIAL FACTOR,EUROCODE,DESIGN APPROACH,LRFD', &
        '`qsmpm-verify partial DECK DA1-2` writes the deck with the partial factors of a code: '// &
        'docs/howto/reliability.md'), &
      topics_type('BEARING LOAD,LIMIT LOAD,FAILURE LOAD,COLLAPSE,FAIL', &
        '*CONTROLS, LIMIT COMPLIANCE= ends a phase at its limit load; docs/methods/limit_loads.md')])
  end function workflow

  !> Topics of soil, laboratory tests and model.
  pure function soil() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('STRAIN SOFTENING,REMOULD,SENSITIVE,RESIDUAL,BRITTLE', &
        '*SOFTENING lets the strength of *MOHR COULOMB fall with plastic shear strain: docs/methods/softening.md'), &
      topics_type('COHESION,FRICTION ANGLE,DILAT,TENSION,NO TENSION,CRACK,S_U,SU,CU,PHI,PSI,C,STRENGTH,'// &
        'SHEAR STRENGTH,YIELD,WEAK,STRONG', &
        '*MOHR COULOMB: c, phi, psi and a tension cut-off; s_u is c with phi = 0, by depth in *STRENGTH PROFILE'), &
      topics_type('SOIL,CLAY,SAND,GRAVEL,ROCK,CONCRETE,STEEL,GRANULAR,TRESCA,VON MISES,MOHR,COULOMB', &
        '*MOHR COULOMB (phi = 0 is Tresca), *DRUCKER PRAGER, *CAM CLAY, *HARDENING SOIL, *NGI ADP (undrained '// &
        'clay), *SOFT SOIL CREEP, *HOEK BROWN (rock), *USER MATERIAL; concrete and steel are *ELASTIC'), &
      topics_type('OCR,POP,OVERCONSOLIDAT,PRECONSOLIDAT', &
        'OCR= and PRECONSOLIDATION= of *CAM CLAY, OCR= of *K0'), &
      topics_type('CREEP,VISC,RATE OF,TIME DEPEND,SECONDARY', &
        '*SOFT SOIL CREEP, in the TIME= of the *PHASE: docs/methods/clay_laws.md; other laws do not flow in time'), &
      topics_type('SHANSEP,STRENGTH GAIN,GAIN OF STRENGTH', &
        '*STRENGTH PROFILE, TYPE=SHANSEP is s_u by the vertical effective stress, *UPDATE STRENGTH what it has '// &
        'gained: docs/methods/undrained.md'), &
      topics_type('HSS,SMALL STRAIN,SMALL-STRAIN', &
        'G0 and gamma_07 of *HARDENING SOIL: docs/methods/hardening_laws.md'), &
      topics_type('ANISOTROP,ADP,DSS,DIRECT SIMPLE SHEAR', &
        '*NGI ADP: undrained strength that differs with the direction of shear: docs/methods/clay_laws.md'), &
      topics_type('HYPOPLASTIC,NORSAND,JOINTED,LIQUEFACTION,CYCLIC,FATIGUE', &
        'there is no such law; nearest: a *USER MATERIAL, your UMAT or UDSM of it: docs/user_models.md'), &
      topics_type('DRAIN,UNDRAINED,EXCESS', &
        '*UNDRAINED below a material, *DRAIN STATE in a phase; without them soil is drained; '// &
        'docs/methods/undrained.md'), &
      topics_type('STIFF,SOFT,HARD,YOUNG,POISSON,MODULUS,E-MODULUS', &
        '*ELASTIC: E and nu, one for each material; by depth in *STRENGTH PROFILE, by stress in *HARDENING '// &
        'SOIL and *CAM CLAY'), &
      topics_type('UMAT,UDSM,OWN LAW,USER MODEL', &
        '*USER MATERIAL calls a UMAT or a UDSM out of a library that tools/build-umat makes; '// &
        'docs/user_models.md'), &
      topics_type('TRIAXIAL,OEDOMETER,LABORATORY,SIMPLE SHEAR,STRESS PATH', &
        '*POINT TEST and *POINT STAGE in a deck of their own, run by qsmpm point; docs/point_tests.md'), &
      topics_type('INTERFACE,FRICTION,ADHESION,SLIP,STICK,RIGID,PILE,CAISSON,SLAB,SPUD,CONE,CPT,T-BAR,BALL,'// &
        'VANE,PIPE,SLIDING,PULL,ROTAT', &
        '*RIGID BODY that the soil may touch by *CONTACT, with friction and adhesion (ON=BODY where soil flows '// &
        'around it), and *MOVE or *LOAD in a phase: docs/methods/contact.md; what is not there yet: docs/cannot.md'), &
      topics_type('AXISYMMETR,PLANE STRAIN,SYMMETR,MIRROR,2D,3D', &
        '*MODEL, TYPE=; AUTO finds the smallest model: docs/scene.md')])
  end function soil

  !> Keywords and terms of other programs.
  pure function other_programs() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('DENSITY,SELF WEIGHT,DEAD WEIGHT,WEIGHT,BODY FORCE', &
        '*UNIT WEIGHT of the material, which *GRAVITY multiplies'), &
      topics_type('ROLLER,BOUNDARY,FIXITY,SUPPORTED', &
        '*FIX holds node sets of the grid, *SUPPORT surfaces that cut it'), &
      topics_type('SURCHARGE,CLOAD,DLOAD,DSLOAD,LOAD,DISTRIBUTED,POINT LOAD,LINE LOAD,FORCE,VEHICLE,TRAFFIC', &
        '*TRACTION is a dead load on a *SURFACE, *PRESSURE follows its normal, *GRAVITY is weight'), &
      topics_type('DISPLACEMENT CONTROL,PRESCRIBED,MOVED,PUSHED', &
        '*PRESCRIBE moves node sets; its reaction is *HISTORY, QUANTITY=REACTION'), &
      topics_type('LARGE DEFORMATION,LARGE STRAIN,NLGEOM,UPDATED LAGRANGE', &
        'always: places, volumes and loads follow the body; the strain measure is KINEMATICS= of *METHOD'), &
      topics_type('REFINE,MESH SIZE,CELL SIZE', &
        'the lines of *GRID; `qsmpm-verify study` tells which grid is fine enough, docs/study.md'), &
      topics_type('AMPLITUDE', &
        'loads grow evenly over a *PHASE, up to its LOAD FACTOR=: more phases make another course'), &
      topics_type('SECTION,INSTANCE,ASSEMBLY', &
        'a *BODY is of one *MATERIAL and fills a box, a polygon, a polyhedron or an element set of the mesh'), &
      topics_type('STEP,INCREMENT,CONVERGENCE,STATIC,QUASI-STATIC,TOLERANCE,NEWTON,ARC LENGTH,LINE SEARCH', &
        '*CONTROLS inside a *PHASE'), &
      topics_type('REACTION,EARTH PRESSURE,KA,KP,BENDING MOMENT,MOMENT', &
        '*HISTORY, QUANTITY=REACTION is the force on a *NSET or a held *SURFACE; STRESS is that at a place; '// &
        'CONTACT FORCE and CONTACT MOMENT are those on a *RIGID BODY'), &
      topics_type('STRESS,STRAIN,DISPLACEMENT,EFFECTIVE STRESS,TOTAL STRESS,PLASTIC', &
        '*HISTORY, QUANTITY= writes one at a place; `qsmpm help FIELDS` lists those of all points, '// &
        '`qsmpm-verify view --field` draws them'), &
      topics_type('OUTPUT,PLOT,PICTURE,ANIMATION,MOVIE,FILM,PARAVIEW,VTK,HDF5,RESULT,CSV,EXCEL', &
        '*FIELD says how often pictures are written, *HISTORY which curves (curves.csv); `qsmpm-verify view` and '// &
        'plot draw them: docs/results.md')])
  end function other_programs

  !> Topics that are no keywords: files, commands, other languages.
  pure function tools() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('DXF,DWG,CAD,AUTOCAD,IFC,STEP FILE', &
        '`qsmpm-verify import FILE.dxf` makes a deck of a section (docs/howto/import.md); DWG is to be saved as '// &
        'DXF, STEP goes through gmsh and *MESH; in space *BODY, SHAPE=POLYHEDRON reads an STL file: '// &
        'docs/tutorial/5_hill.md'), &
      topics_type('GEOSTUDIO,SLOPE/W,GSZ', &
        '`qsmpm-verify import FILE.gsz` makes a deck of a project: regions, soils, water (docs/howto/import.md)'), &
      topics_type('GMSH,ABAQUS,PLAXIS,IMPORT,STL', &
        '*MESH reads a mesh of gmsh or Abaqus, *BODY, SHAPE=POLYHEDRON an STL file: docs/tutorial/5_hill.md; decks '// &
        'of older versions are changed by tools/convert-deck'), &
      topics_type('GEOMETRY,SHAPE,DRAW', &
        '*BODY draws boxes, polygons and polyhedra over a *GRID or a *MESH, whose cells they cut as they like'), &
      topics_type('RESUME,CONTINUE', &
        '`qsmpm run DECK --restart FILE` goes on from restart.h5; *RESTART says how often it is written'), &
      topics_type('PYTHON,FORTRAN,MATLAB,API,EMBED', &
        'the library is called from Fortran, C, Fortran 77 and Python: docs/embedding.md'), &
      topics_type('PARDISO,MUMPS,UMFPACK,CHOLMOD', &
        '*SOLVER chooses the solver of linear equations'), &
      topics_type('THREADS,SPEED,COST,MEMORY,PARALLEL,CORES', &
        '`qsmpm plan DECK` tells the cost before a run, --threads N takes more cores: docs/performance.md'), &
      topics_type('MPI,CLUSTER,PROCESSES,RANKS,SUPERCOMPUTER', &
        'qsmpm-mpi divides the ground among processes, of many machines too: docs/distributed.md'), &
      topics_type('ACCURA,ERROR', &
        'the log tells the error of the stresses; `qsmpm-verify study DECK --history NAME` that of a result: '// &
        'docs/study.md'), &
      topics_type('PROBABIL,RANDOM,RELIABILITY,MONTE CARLO,SPATIAL,SENSITIVITY,CALIBRAT,BACK ANALYSIS,INVERSE', &
        '`qsmpm-verify reliability DECK FILE` tells how likely an answer is beyond its limit, of numbers and of '// &
        'strength that scatters from place to place: docs/howto/reliability.md; other runs of many are '// &
        'written in Python: docs/howto/many_runs.md; a law is fitted by *POINT TEST: docs/point_tests.md')])
  end function tools

  !> Topics that are not available.
  pure function missing() result(known)
    type(topics_type), allocatable :: known(:)

    allocate (known, source=[ &
      topics_type('SHEET PILE,SHEETPILE,WALL,RETAINING,DIAPHRAGM,COFFERDAM', &
        'walls that bend are not there; nearest: a *BODY of stiff *ELASTIC a few cells thick, held by *PROP, a '// &
        '*RIGID BODY that slips along the soil by *CONTACT, *SUPPORT for a wall that holds: docs/cannot.md'), &
      topics_type('STRUT,PROP,SPRING,JACK,SHORING,ANCHOR,NAIL,SOIL NAIL,TIE,TIE ROD,TIEBACK,BOLT,CABLE,TRUSS', &
        '*PROP is a spring between two places that phases put in, jack and take out: a strut, or the free length '// &
        'of an anchor, which passes the soil untouched. Bonded anchors and nails are not there: docs/cannot.md'), &
      topics_type('GEOGRID,GEOTEXTILE,BEAM,PLATE,SHELL,LINING,SHOTCRETE,COLUMN,STONE COLUMN,GROUT', &
        'structural elements are not there; nearest: a *BODY of stiff *ELASTIC a few cells thick; *PROP is a '// &
        'spring between two places: docs/cannot.md'), &
      topics_type('CONSOLIDAT', &
        '*CONSOLIDATION lets excess pore pressure flow away in the TIME of phases; for its beginning and end alone '// &
        '*UNDRAINED soil and *DRAIN STATE: docs/methods/consolidation.md'), &
      topics_type('SEEPAGE,DARCY,FLOW,WELL,PIPING,PHREATIC,FREE SURFACE', &
        'flow is *WATER LEVEL, TYPE=SEEPAGE with a *PERMEABILITY of each material, steady or FLOW=TRANSIENT, '// &
        'excess pressure that flows away in time *CONSOLIDATION: docs/methods/seepage.md'), &
      topics_type('RAIN,INFILTRAT', &
        'steady rain is the third number of *WATER LEVEL, TYPE=SEEPAGE: docs/methods/seepage.md'), &
      topics_type('EROSION', &
        'water that takes soil away is not there; nearest: *WATER LEVEL, TYPE=SEEPAGE, which warns where soil is '// &
        'lifted: docs/methods/seepage.md'), &
      topics_type('EARTHQUAKE,DYNAMIC,VIBRAT,WAVE,INERTIA,VELOCITY,IMPACT,BLAST,SEISMIC,PSEUDO-STATIC', &
        'there is no inertia: every step is an equilibrium; nearest: a horizontal share of *GRAVITY '// &
        '(pseudo-static): docs/cannot.md'), &
      topics_type('TIME', &
        'every step is an equilibrium; TIME= of *PHASE is for *CONSOLIDATION, *SOFT SOIL CREEP and a *USER '// &
        'MATERIAL that depends on it'), &
      topics_type('HEAT,THERMAL,TEMPERATURE,FREEZ,UNSATURAT,SUCTION,SWELL,SHRINK,EXPANSIVE,GAS', &
        'temperature, suction and gas are not there: docs/cannot.md'), &
      topics_type('GPU,CUDA', &
        'GPUs are not used: --threads N takes more cores, qsmpm-mpi many processes: docs/distributed.md')])
  end function missing

  !> Returns the current name of a word; empty if it was not renamed.
  pure function renamed(where, old) result(new)
    !> `keyword`, or the current keyword to which a parameter belongs; the word in capitals, without a star.
    character(len=*), intent(in) :: where, old
    character(len=:), allocatable :: new
    integer :: i

    new = ''
    do i = 1, size(words)
      if (words(i)%where == where .and. words(i)%old == old) new = trim(words(i)%new)
    end do
  end function renamed

  !> Returns all renamed words as a table in Markdown.
  pure function renamed_text() result(text)
    character(len=:), allocatable :: text
    integer :: i

    text = '| where | old | new |'//new_line('a')//'|---|---|---|'//new_line('a')
    do i = 1, size(words)
      text = text//'| '//shown(words(i)%where)//' | `'//trim(words(i)%old)//'` | `'//trim(words(i)%new)//'` |'// &
        new_line('a')
    end do
  end function renamed_text

  !> Returns the position of a word in terms of the deck.
  pure function shown(where) result(text)
    character(len=*), intent(in) :: where
    character(len=:), allocatable :: text

    text = '*'//trim(where)
    if (where == keyword .or. where == curves) text = trim(where)
  end function shown
end module qsmpm_help_topics
