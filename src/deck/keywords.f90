!> Keyword table: every keyword, option and field once. It drives the reader, `limber help`, the reference chapter of the manual and
!> the effective deck. Rows of the language, of bodies, analyses and outputs are here. Each joint, driver and load brings its own
!> rows: `register_elements` of floor elements adds them. Floor: deck.
module limber_deck_keywords
   use limber_deck_body_options, only: body_options, beam_options, frame_options
   use limber_deck_lexer, only: collapsed
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, list_spec_type, word_spec_type, &
      & keyword_rows_type, many, needed, kind_name, &
      & kind_reference, kind_real, kind_positive, kind_nonnegative, kind_count, kind_counting, kind_word, kind_text, &
      & kind_path, kind_point, kind_yes, kind_time_expression, kind_law, kind_spring_law, kind_shape, kind_curve, kind_label, &
      & kind_range, form_none, form_text, form_fields, form_assignments, form_channels, form_lists
   implicit none
   private
   public :: load_language, add_rows, find_keyword, keyword_options, keyword_fields, keyword_lists, keyword_words, &
      & keyword_example, &
      & split_values, contains_value, alternatives

   !> The table, after `load_language`: all keywords in the order of the manual, all options in the order of their keywords
   type(keyword_type), allocatable, protected, public :: keyword_table(:)
   type(option_spec_type), allocatable, protected, public :: option_table(:)
   !> Rows of joints, drivers and loads
   type(keyword_rows_type), allocatable :: element_rows(:)

   interface
      !> Adds the rows of all joints, drivers and loads by `add_rows`. Its body is `src/elements/registration.f90`.
      module subroutine register_elements()
      end subroutine register_elements
   end interface

   !> Keywords without those of joints, drivers and loads, which stand before *ASSEMBLY
   type(keyword_type), parameter :: own_keywords(*) = [ &
      & keyword_type('HEADING', 1, form_text, 0, many, 'A title: free text, stored with the results'), &
      & keyword_type('PARAMETER', many, form_assignments, 1, many, &
      &    'Named numbers, name = expression; usable behind their definition wherever a number is'), &
      & keyword_type('EXPRESSION', many, form_assignments, 1, many, &
      &    'Named expressions of time and motion, name = expression; usable behind their definition in all others'), &
      & keyword_type('INCLUDE', many, form_none, 0, 0, 'Reads another file as if it stood here'), &
      & keyword_type('REPEAT', many, form_none, 0, 0, &
      &    'Repeats all up to its *END REPEAT; in names and texts <i>, <i - 1>, ... is a whole number'), &
      & keyword_type('END REPEAT', many, form_none, 0, 0, 'The end of a *REPEAT, which may hold others'), &
      & keyword_type('UNITS', 1, form_none, 0, 0, &
      &    'Units of the numbers of this deck: they label the results, and gravity has its default in them'), &
      & keyword_type('MATERIAL', many, form_none, 0, 0, 'An elastic material'), &
      & keyword_type('SECTION', many, form_none, 0, 0, 'The cross-section of a beam'), &
      & keyword_type('GRAVITY', 1, form_none, 0, 0, 'Acceleration of gravity; without this block there is none'), &
      & keyword_type('GROUND', many, form_fields, 1, many, &
      &    'Points fixed in space, used as ground.point; ground.origin is there already'), &
      & keyword_type('RIGID BODY', many, form_fields, 0, many, 'A rigid body; data lines: its named points'), &
      & keyword_type('POINT MASS', many, form_none, 0, 0, 'A mass without extent and rotation'), &
      & keyword_type('BEAM', many, form_fields, 0, many, &
      &    'A flexible beam in a floating frame of reference; data lines: its named points'), &
      & keyword_type('FRAME', many, form_fields, 0, many, &
      &    'A flexible body of straight members, rigidly joined; data lines: its named points along members'), &
      & keyword_type('NODE', many, form_fields, 1, many, 'Nodes of a frame'), &
      & keyword_type('ELEMENT', many, form_fields, 1, many, 'Straight members of a frame'), &
      & keyword_type('NSET', many, form_fields, 1, many, 'A set of nodes of a frame; several blocks of one set add up'), &
      & keyword_type('ELSET', many, form_fields, 1, many, 'A set of members of a frame; several blocks of one set add up'), &
      & keyword_type('BEAM SECTION', many, form_none, 0, 0, 'Material and cross-section of a set of members'), &
      & keyword_type('BOUNDARY', many, form_fields, 1, many, &
      &    'What holds nodes of a frame in its floating frame: defines the modes'), &
      & keyword_type('MASS', many, form_fields, 1, many, 'Concentrated masses on nodes of a frame or points of a beam'), &
      & keyword_type('PROFILE', many, form_fields, 1, many, 'Other sections of an EXACT beam, from a coordinate on'), &
      & keyword_type('ATTACHMENT', many, form_fields, 1, many, &
      &    'Functions of a frame or beam beside its modes: static responses to a unit force or couple; or its interface'), &
      & keyword_type('TABLE', many, form_fields, 0, many, &
      &    'A function of one argument for expressions behind it, name(x): its points; beyond them it keeps its last value'), &
      & keyword_type('CURVE', many, form_fields, 0, many, &
      &    'A curve in the frame of a body, for joints: points, or one line with y as an expression of x'), &
      & keyword_type('DAMPING', many, form_fields, 0, many, &
      &    'Damping of the vibrations of a beam or frame; data lines: modes with a ratio of their own'), &
      & keyword_type('ASSEMBLY', 1, form_fields, 0, many, &
      &    'How the first position is found from the guesses; data lines: given deflections'), &
      & keyword_type('KINEMATICS', many, form_none, 0, 0, &
      &    'An analysis: the motion of a scene that its drivers move wholly, position by position, and its reactions'), &
      & keyword_type('INVERSE DYNAMICS', many, form_none, 0, 0, &
      &    'An analysis: the torques and forces that drivers need for the motion that they prescribe'), &
      & keyword_type('STATICS', many, form_none, 0, 0, 'An analysis: equilibrium under loads that grow, and its stability'), &
      & keyword_type('MODES', many, form_none, 0, 0, &
      &    'An analysis: frequencies and shapes of small vibrations about the present state'), &
      & keyword_type('DYNAMICS', many, form_none, 0, 0, 'An analysis: the motion in a stretch of time'), &
      & keyword_type('ACCURACY', 1, form_none, 0, 0, 'What is to be known of the error of the results of limber run'), &
      & keyword_type('STUDY', 1, form_lists, 0, many, 'What limber study varies, to weigh speed against error'), &
      & keyword_type('SWEEP', 1, form_fields, 0, many, &
      &    'What limber sweep varies: parameters of the deck, a line each; a run for each combination of their values'), &
      & keyword_type('SCALAR', many, form_channels, 1, many, &
      &    'Single numbers of a run: name = expression of first, last, minimum, maximum, mean, rms of (channel)'), &
      & keyword_type('OUTPUT', many, form_channels, 0, many, &
      &    'Channels of the results, several in a line: quantity(object) or name = expression of quantities')]
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: setting_options(*) = [ &
      & option_spec_type('INCLUDE', 'FILE', kind_path, '', '', needed, 'path, relative to the folder of this file'), &
      & option_spec_type('REPEAT', 'COUNT', kind_count, '', '', needed, 'number of turns', most=200000), &
      & option_spec_type('REPEAT', 'INDEX', kind_name, 'parameters', '', needed, &
      &    'parameter that counts the turns; it ends with them, as do parameters that are defined between'), &
      & option_spec_type('REPEAT', 'FROM', kind_count, '', '', '1', 'value of the index in the first turn'), &
      & option_spec_type('UNITS', 'LENGTH', kind_text, '', '', 'm', 'unit of length'), &
      & option_spec_type('UNITS', 'TIME', kind_text, '', '', 's', 'unit of time'), &
      & option_spec_type('UNITS', 'MASS', kind_text, '', '', 'kg', 'unit of mass'), &
      & option_spec_type('MATERIAL', 'NAME', kind_name, 'materials', '', needed, 'name of the material'), &
      & option_spec_type('MATERIAL', 'YOUNG', kind_positive, '', 'Pa', needed, 'Young''s modulus'), &
      & option_spec_type('MATERIAL', 'DENSITY', kind_positive, '', 'kg/m^3', needed, 'mass per volume'), &
      & option_spec_type('MATERIAL', 'POISSON', kind_real, '', '', '0.3', 'Poisson''s ratio, for beams with SHEAR'), &
      & option_spec_type('SECTION', 'NAME', kind_name, 'sections', '', needed, 'name of the section'), &
      & option_spec_type('SECTION', 'SHAPE', kind_word, 'CIRCLE|RECTANGLE|TUBE|GENERAL', &
      &    '', needed, 'shape; decides which of the other options are needed'), &
      & option_spec_type('SECTION', 'DIAMETER', kind_positive, '', 'm', '', '(outer) diameter of CIRCLE and TUBE', &
      &    only='SHAPE=CIRCLE|TUBE'), &
      & option_spec_type('SECTION', 'WIDTH', kind_positive, '', &
      &    'm', '', 'width of RECTANGLE, across the plane of bending', only='SHAPE=RECTANGLE'), &
      & option_spec_type('SECTION', 'HEIGHT', kind_positive, '', 'm', '', 'height of RECTANGLE, in the plane of bending', &
      &    only='SHAPE=RECTANGLE'), &
      & option_spec_type('SECTION', 'THICKNESS', kind_positive, '', 'm', '', 'thickness of the wall of TUBE', &
      &    only='SHAPE=TUBE'), &
      & option_spec_type('SECTION', 'AREA', kind_positive, '', 'm^2', '', 'area of GENERAL', only='SHAPE=GENERAL'), &
      & option_spec_type('SECTION', 'INERTIA', kind_positive, '', &
      &    'm^4', '', 'second moment of area of GENERAL for bending in the plane', only='SHAPE=GENERAL'), &
      & option_spec_type('SECTION', 'TOP', kind_positive, '', &
      &    'm', '', 'GENERAL: distance from the axis of the extreme fibre to the left of the beam, for stresses', &
      &    only='SHAPE=GENERAL'), &
      & option_spec_type('SECTION', 'BOTTOM', kind_positive, '', 'm', '', 'GENERAL: the same to the right; if not given, TOP', &
      &    only='SHAPE=GENERAL'), &
      & option_spec_type('SECTION', 'SHEAR FACTOR', kind_positive, '', &
      &    '', '', 'area in shear divided by area; default 5/6 of RECTANGLE, 6/7 of CIRCLE, of TUBE by its wall'), &
      & option_spec_type('GRAVITY', 'X', kind_real, '', 'm/s^2', '0', 'along x'), &
      & option_spec_type('GRAVITY', 'Y', kind_real, '', 'm/s^2', '-9.81', 'along y')]
   type(option_spec_type), parameter :: other_options(*) = [ &
      & option_spec_type('TABLE', 'NAME', kind_name, 'tables', '', needed, 'name of the function'), &
      & option_spec_type('TABLE', 'INTERPOLATION', kind_word, 'LINEAR|SPLINE', &
      &    '', 'LINEAR', 'straight between the points, or the cubic spline without curvature at its ends'), &
      & option_spec_type('TABLE', 'FILE', kind_path, '', &
      &    '', '', 'file of data lines, relative to the folder of this one; a line that begins with a letter is skipped'), &
      & option_spec_type('CURVE', 'NAME', kind_name, 'curves', '', needed, 'name of the curve'), &
      & option_spec_type('CURVE', 'CLOSED', kind_yes, '', '', 'NO', 'the spline through the points ends where it begins'), &
      & option_spec_type('CURVE', 'FILE', kind_path, '', &
      &    '', '', 'file of data lines, relative to the folder of this one; a line that begins with a letter is skipped'), &
      & option_spec_type('DAMPING', 'BODY', kind_reference, 'BEAM|FRAME', '', needed, 'beam or frame that is damped'), &
      & option_spec_type('DAMPING', 'RAYLEIGH ALPHA', kind_nonnegative, '', &
      &    '1/s', '0', 'damping for each unit of modal mass of modes as the scene holds it; internal: section forces have it'), &
      & option_spec_type('DAMPING', 'RAYLEIGH BETA', kind_nonnegative, '', &
      &    's', '0', 'damping for each unit of modal stiffness'), &
      & option_spec_type('DAMPING', 'RATIO', kind_nonnegative, '', &
      &    '', '0', 'part of the critical damping of each mode, as joints and springs hold the body at first, without loads'), &
      & option_spec_type('ASSEMBLY', 'LARGEST TURN', kind_positive, '', &
      &    'rad', '0.5', 'rotation of a body from its guess beyond which there is a warning: another branch may be meant'), &
      & option_spec_type('ASSEMBLY', 'INITIAL DEFLECTIONS', kind_word, 'ZERO|GIVEN|STATIC|FOLLOWING', &
      &    '', 'ZERO', 'ZERO: but for what joints bend; GIVEN: by data lines; STATIC'// &
      &    ': in balance, at rest; FOLLOWING: with its rates'), &
      & option_spec_type('ASSEMBLY', 'ELIMINATION', kind_yes, '', &
      &    '', 'YES', 'NO: bodies keep all unknowns and joints their multipliers, even where the motion is known; to compare'), &
      & option_spec_type('DYNAMICS', 'NAME', kind_name, 'analyses', '', '', 'name of the step in the results'), &
      & option_spec_type('DYNAMICS', 'START', kind_real, '', &
      &    's', '0', 'first instant; if not given behind another analysis, the end of that'), &
      & option_spec_type('DYNAMICS', 'END', kind_real, '', 's', needed, &
      &    'last instant; the time goes on from the analysis before'), &
      & option_spec_type('DYNAMICS', 'OUTPUTS', kind_counting, '', &
      &    '', '100', 'equal intervals between samples of the output: one sample more than intervals', most=10000000), &
      & option_spec_type('DYNAMICS', 'TOLERANCE', kind_positive, '', &
      &    '', '1e-6', 'bound of the local error of a step, relative and absolute'), &
      & option_spec_type('DYNAMICS', 'INTEGRATOR', kind_word, 'AUTO|ADAMS|ALPHA|RADAU|CONSERVING', &
      &    '', 'AUTO', 'integration method; AUTO: chosen from the scene and the tolerance, and said in the report'), &
      & option_spec_type('DYNAMICS', 'SPECTRAL RADIUS', kind_nonnegative, '', &
      &    '', '0.8', 'ALPHA: 1 damps no vibration, 0 all that the step does not resolve', only='INTEGRATOR=ALPHA|AUTO'), &
      & option_spec_type('DYNAMICS', 'INITIAL STEP', kind_positive, '', &
      &    's', '', 'first step; if not given, chosen by the integrator', only='-FIXED STEP'), &
      & option_spec_type('DYNAMICS', 'MAXIMUM STEP', kind_positive, '', &
      &    's', '', 'longest step; if not given, not limited', only='-FIXED STEP'), &
      & option_spec_type('DYNAMICS', 'FIXED STEP', kind_positive, '', &
      &    's', '', 'length of every step, whatever its error; TOLERANCE then ends iterations only'), &
      & option_spec_type('DYNAMICS', 'MAXIMUM STEPS', kind_counting, '', &
      &    '', '100000000', 'number of steps after which the run gives up'), &
      & option_spec_type('DYNAMICS', 'VELOCITIES', kind_word, 'KEPT|REST|DECK', &
      &    '', '', 'after another analysis: those at its end (default), none, or those that the deck gives the bodies'), &
      & option_spec_type('ACCURACY', 'ESTIMATE', kind_yes, '', &
      &    '', 'NO', 'error of time integration beside each channel, by runs at other tolerances; no analysis but one *DYNAMICS', &
      &    only='-TARGET'), &
      & option_spec_type('ACCURACY', 'TARGET', kind_positive, '', &
      &    '', '', 'error of channels by their largest values, for which limber chooses a model; of one *DYNAMICS alone'), &
      & option_spec_type('STUDY', 'REPEATS', kind_counting, '', &
      &    '', '3', 'runs of each setting that can be worth its time; their median counts', most=1000), &
      & option_spec_type('STUDY', 'REFERENCE', kind_path, '', &
      &    '', '', 'results (.h5) or columns with names (.csv) to compare with; if not given, limber makes its own'), &
      & option_spec_type('STUDY', 'BEAM', kind_reference, 'BEAM', '', '', 'the beam that is varied; if not given, all'), &
      & option_spec_type('STUDY', 'ERROR', kind_positive, '', '', '0.01', 'relative error that the advice aims at'), &
      & option_spec_type('STUDY', 'LIMIT', kind_positive, '', &
      &    's', '30', 'CPU time of this machine after which a run is given up'), &
      & option_spec_type('SWEEP', 'METHOD', kind_word, 'GRID|PAIRS|LATIN HYPERCUBE', &
      &    '', 'GRID', 'all combinations; first values together, second ones, ...; or samples spread over ranges'), &
      & option_spec_type('SWEEP', 'FILE', kind_path, '', &
      &    '', '', 'columns with the names of parameters above them (.csv); its rows count as one more line', &
      &    only='METHOD=GRID|PAIRS'), &
      & option_spec_type('SWEEP', 'SAMPLES', kind_counting, '', '', '100', 'LATIN HYPERCUBE: number of runs', most=100000, &
      &    only='METHOD=LATIN HYPERCUBE'), &
      & option_spec_type('SWEEP', 'SEED', kind_counting, '', '', '1', 'LATIN HYPERCUBE: another number, other samples', &
      &    only='METHOD=LATIN HYPERCUBE'), &
      & option_spec_type('SWEEP', 'KEEP', kind_yes, '', &
      &    '', 'NO', 'whether the whole history of each run is kept, in the folder beside the summary'), &
      & option_spec_type('SWEEP', 'LIMIT', kind_positive, '', &
      &    's', '', 'CPU time after which a run is given up as failed; if not given, never'), &
      & option_spec_type('OUTPUT', 'ENVELOPE', kind_reference, 'BEAM|FRAME', &
      &    '', '', 'least and greatest internal forces and stresses along it over all samples, in bodies/<name>/envelope'), &
      & option_spec_type('OUTPUT', 'MOTION', kind_yes, '', &
      &    '', 'NO', 'the coordinates of all bodies at each sample, and their outlines: what postproc/draw draws')]
   type(option_spec_type), parameter :: analysis_options(*) = [ &
      & option_spec_type('KINEMATICS', 'NAME', kind_name, 'analyses', '', '', 'name of the step in the results'), &
      & option_spec_type('KINEMATICS', 'START', kind_real, '', &
      &    's', '0', 'first instant; if not given behind another analysis, the end of that'), &
      & option_spec_type('KINEMATICS', 'END', kind_real, '', 's', needed, &
      &    'last instant; the time goes on from the analysis before'), &
      & option_spec_type('KINEMATICS', 'OUTPUTS', kind_counting, '', '', '100', 'equal intervals between samples of the output', &
      &    most=10000000), &
      & option_spec_type('KINEMATICS', 'DEFLECTIONS', kind_word, 'HELD|STATIC', &
      &    '', 'HELD', 'of beams: held as they are, or in equilibrium at each sample with loads and inertia of the motion'), &
      & option_spec_type('INVERSE DYNAMICS', 'NAME', kind_name, 'analyses', '', '', 'name of the step in the results'), &
      & option_spec_type('INVERSE DYNAMICS', 'START', kind_real, '', &
      &    's', '0', 'first instant; if not given behind another analysis, the end of that'), &
      & option_spec_type('INVERSE DYNAMICS', 'END', kind_real, '', 's', needed, &
      &    'last instant; the time goes on from the analysis before'), &
      & option_spec_type('INVERSE DYNAMICS', 'OUTPUTS', kind_counting, '', &
      &    '', '100', 'equal intervals between samples of the output', most=10000000), &
      & option_spec_type('INVERSE DYNAMICS', 'DEFLECTIONS', kind_word, 'HELD|STATIC', &
      &    '', 'STATIC', 'of beams: held as they are, or in equilibrium at each sample with loads and inertia of the motion'), &
      & option_spec_type('STATICS', 'NAME', kind_name, 'analyses', '', '', 'name of the step in the results'), &
      & option_spec_type('STATICS', 'PERIOD', kind_nonnegative, '', &
      &    's', '1', 'time that passes; with 0 the equilibrium of this instant is sought'), &
      & option_spec_type('STATICS', 'INCREMENTS', kind_counting, '', &
      &    '', '10', 'equal parts of the time, a sample at the end of each; divided further where that is needed', most=10000000), &
      & option_spec_type('STATICS', 'RAMP', kind_yes, '', &
      &    '', '', 'weight and constant loads grow from zero (not THERMAL STRAIN); default YES in the first analysis, else NO'), &
      & option_spec_type('STATICS', 'INSTABILITY', kind_word, 'LEAVE|STAY|STOP', &
      &    '', 'LEAVE', 'where equilibrium turns unstable: go on with a stable one, stay, or end the run'), &
      & option_spec_type('STATICS', 'ROTATION', kind_real, '', &
      &    'rad/s', '0', 'speed at which everything turns about the centre at the end; grows from that before'), &
      & option_spec_type('STATICS', 'CENTRE X', kind_real, '', 'm', '0', 'x of the centre of ROTATION', only='ROTATION'), &
      & option_spec_type('STATICS', 'CENTRE Y', kind_real, '', 'm', '0', 'y of the centre of ROTATION', only='ROTATION'), &
      & option_spec_type('MODES', 'NAME', kind_name, 'analyses', '', '', 'name of the step in the results'), &
      & option_spec_type('MODES', 'NUMBER', kind_counting, '', '', '10', 'number of modes: those of the lowest frequencies', &
      &    most=1000), &
      & option_spec_type('MODES', 'DAMPED', kind_yes, '', '', 'NO', &
      &    'whether velocities count, in dampers or forces across the velocity: frequencies with damping ratios')]
   !> Their options
   type(option_spec_type), parameter :: own_options(*) = [setting_options, body_options, beam_options, frame_options, &
      & other_options, analysis_options]
   !> Fields of their data lines of the form `form_fields`
   type(field_spec_type), parameter :: own_fields(*) = [ &
      & field_spec_type('GROUND', 'point', kind_name, '', 'name of the point'), &
      & field_spec_type('GROUND', 'x', kind_real, 'm', 'position'), &
      & field_spec_type('GROUND', 'y', kind_real, 'm', 'position'), &
      & field_spec_type('RIGID BODY', 'point', kind_name, '', 'name of the point, used as body.point'), &
      & field_spec_type('RIGID BODY', 'x', kind_real, 'm', 'position in the body frame'), &
      & field_spec_type('RIGID BODY', 'y', kind_real, 'm', 'position in the body frame'), &
      & field_spec_type('BEAM', 'point', kind_name, '', 'name of the point, used as beam.point'), &
      & field_spec_type('BEAM', 'coordinate', kind_real, 'm', 'coordinate along the undeformed beam from its start'), &
      & field_spec_type('ASSEMBLY', 'beam', kind_name, '', 'name of the beam'), &
      & field_spec_type('ASSEMBLY', 'coordinate', kind_counting, '', 'its number: bending first, then axial, by frequency'), &
      & field_spec_type('ASSEMBLY', 'value', kind_real, 'm kg^0.5', 'deflection in units of the mass-normalised shape'), &
      & field_spec_type('ASSEMBLY', 'rate', kind_real, '', 'its rate'), &
      & field_spec_type('FRAME', 'point', kind_name, '', 'name of the point, used as frame.point'), &
      & field_spec_type('FRAME', 'member', kind_counting, '', 'number of the member'), &
      & field_spec_type('FRAME', 'coordinate', kind_real, 'm', 'coordinate along the undeformed member from its first node'), &
      & field_spec_type('NODE', 'number', kind_counting, '', 'number of the node'), &
      & field_spec_type('NODE', 'x', kind_real, 'm', 'place in the body frame'), &
      & field_spec_type('NODE', 'y', kind_real, 'm', 'place in the body frame'), &
      & field_spec_type('NODE', 'point', kind_name, '', 'name of a point there, used as frame.point', optional=.true.), &
      & field_spec_type('ELEMENT', 'number', kind_counting, '', 'number of the member'), &
      & field_spec_type('ELEMENT', 'first node', kind_counting, '', 'number of the node at its start'), &
      & field_spec_type('ELEMENT', 'second node', kind_counting, '', 'number of the node at its end'), &
      & field_spec_type('ELEMENT', 'section', kind_name, '', 'its cross-section, if not that of the block', optional=.true.), &
      & field_spec_type('NSET', 'node', kind_counting, '', 'numbers of nodes', repeated=.true.), &
      & field_spec_type('ELSET', 'member', kind_counting, '', 'numbers of members', repeated=.true.), &
      & field_spec_type('BOUNDARY', 'node', kind_label, '', 'number of a node, or a set of nodes'), &
      & field_spec_type('BOUNDARY', 'first', kind_counting, '', 'first degree of freedom held: 1 is x, 2 is y, 6 the rotation'), &
      & field_spec_type('BOUNDARY', 'last', kind_counting, '', 'last one held; if not given, only the first', optional=.true.), &
      & field_spec_type('MASS', 'place', kind_label, '', &
      &    'number of a node or a set of nodes; of a beam: a coordinate or one of its points'), &
      & field_spec_type('MASS', 'mass', kind_nonnegative, 'kg', 'mass on each'), &
      & field_spec_type('MASS', 'inertia', kind_nonnegative, 'kg m^2', &
      &    'moment of inertia about the node, turning with its section', optional=.true.), &
      & field_spec_type('PROFILE', 'coordinate', kind_real, 'm', 'along the undeformed beam: the section is this from here on'), &
      & field_spec_type('PROFILE', 'section', kind_name, '', 'its cross-section'), &
      & field_spec_type('PROFILE', 'end section', kind_name, '', &
      &    'the section at the next coordinate, or at the end; sizes change linearly up to it', optional=.true.), &
      & field_spec_type('ATTACHMENT', 'place', kind_label, '', &
      &    'number of a node or a set of nodes; of a beam: a coordinate or one of its points'), &
      & field_spec_type('ATTACHMENT', 'freedom', kind_counting, '', 'degree of freedom: 1 is x, 2 is y, 6 the rotation'), &
      & field_spec_type('TABLE', 'x', kind_real, '', 'argument, greater than the one before'), &
      & field_spec_type('TABLE', 'value', kind_real, '', 'value there'), &
      & field_spec_type('CURVE', 'x', kind_curve, 'm', 'of a point; or y of the curve as an expression of x, in one line'), &
      & field_spec_type('CURVE', 'y', kind_real, 'm', 'of a point', .true.), &
      & field_spec_type('SWEEP', 'parameter', kind_name, '', 'name of a parameter of the deck'), &
      & field_spec_type('SWEEP', 'value', kind_range, '', 'numbers, or first:last:count; of LATIN HYPERCUBE first:last', &
      &    repeated=.true.), &
      & field_spec_type('DAMPING', 'mode', kind_counting, '', 'number of a mode that strains the body, ascending frequencies'), &
      & field_spec_type('DAMPING', 'ratio', kind_nonnegative, '', 'part of the critical damping, in place of RATIO')]
   !> The lists of data lines of the form `form_lists`
   type(list_spec_type), parameter :: list_table(*) = [ &
      & list_spec_type('STUDY', 'integrators', 'DYNAMICS', 'INTEGRATOR', 'integration methods; default all'), &
      & list_spec_type('STUDY', 'tolerances', 'DYNAMICS', 'TOLERANCE', 'tolerances; default 1e-2, 1e-3, ... 1e-6'), &
      & list_spec_type('STUDY', 'steps', 'DYNAMICS', 'FIXED STEP', 'fixed steps, in place of tolerances'), &
      & list_spec_type('STUDY', 'modes', 'BEAM', 'MODES', 'numbers of modes'), &
      & list_spec_type('STUDY', 'bending modes', 'BEAM', 'BENDING MODES', 'numbers of bending modes'), &
      & list_spec_type('STUDY', 'geometric elements', 'BEAM', 'GEOMETRIC ELEMENTS', 'numbers of elements of the geometric part'), &
      & list_spec_type('STUDY', 'functions', 'BEAM', 'FUNCTIONS', 'numbers of functions of exact beams'), &
      & list_spec_type('STUDY', 'strain functions', 'BEAM', 'STRAIN FUNCTIONS', 'numbers of functions of the strain'), &
      & list_spec_type('STUDY', 'fidelities', 'BEAM', 'GEOMETRIC', 'fidelities'), &
      & list_spec_type('STUDY', 'channels', '', '', 'channels of *OUTPUT that are compared; default all')]

contains

   !> Fills the table once. Readers of decks and help call it before they use the table.
   subroutine load_language()
      integer :: i, first
      if (allocated(keyword_table)) return
      allocate (element_rows(0))
      call register_elements()
      first = findloc(own_keywords%name == 'ASSEMBLY', .true., dim=1)
      allocate (keyword_table, source=[own_keywords(:first - 1), (element_rows(i)%keyword, i=1, size(element_rows)), &
         & own_keywords(first:)])
      allocate (option_table, source=[own_options, (element_rows(i)%options, i=1, size(element_rows))])
   end subroutine load_language

   !> Adds the rows of a keyword.
   subroutine add_rows(rows)
      type(keyword_rows_type), intent(in) :: rows
      type(keyword_rows_type), allocatable :: longer(:)
      integer :: i
      allocate (longer(size(element_rows) + 1))
      do i = 1, size(element_rows)
         longer(i) = element_rows(i)
      end do
      longer(i) = rows
      call move_alloc(longer, element_rows)
   end subroutine add_rows

   !> Index of a keyword in the table, written in any case; 0: unknown.
   pure integer function find_keyword(name) result(found)
      character(*), intent(in) :: name
      character(:), allocatable :: wanted
      wanted = collapsed(name)
      do found = size(keyword_table), 1, -1
         if (keyword_table(found)%name == wanted) return
      end do
   end function find_keyword

   !> Index of an element's rows by its keyword; 0: it is no element.
   pure integer function find_rows(keyword) result(found)
      !> In upper case
      character(*), intent(in) :: keyword
      do found = size(element_rows), 1, -1
         if (element_rows(found)%keyword%name == keyword) return
      end do
   end function find_rows

   !> The options of a keyword, in the order of the table.
   pure function keyword_options(keyword) result(options)
      !> In upper case
      character(*), intent(in) :: keyword
      type(option_spec_type), allocatable :: options(:)
      integer :: i, first, last
      first = 1
      last = 0
      do i = 1, size(option_table)
         ! Most differ in their first letter: asked for at each block of a deck
         if (option_table(i)%keyword(1:1) /= keyword(1:1)) cycle
         if (option_table(i)%keyword /= keyword) cycle
         if (last == 0) first = i
         last = i
      end do
      allocate (options(last - first + 1))
      options(:) = option_table(first:last)
   end function keyword_options

   !> The fields of the data lines of a keyword.
   pure function keyword_fields(keyword) result(fields)
      !> In upper case
      character(*), intent(in) :: keyword
      type(field_spec_type), allocatable :: fields(:)
      integer :: row
      row = find_rows(keyword)
      if (row > 0) then
         allocate (fields, source=element_rows(row)%fields)
      else
         allocate (fields, source=pack(own_fields, own_fields%keyword == keyword))
      end if
   end function keyword_fields

   !> Meaning of the words of a keyword's options.
   pure function keyword_words(keyword) result(words)
      !> In upper case
      character(*), intent(in) :: keyword
      type(word_spec_type), allocatable :: words(:)
      integer :: row
      row = find_rows(keyword)
      if (row > 0) then
         allocate (words, source=element_rows(row)%words)
      else
         allocate (words(0))
      end if
   end function keyword_words

   !> Lines of the example of an element; none for other keywords.
   pure function keyword_example(keyword) result(lines)
      !> In upper case
      character(*), intent(in) :: keyword
      character(110), allocatable :: lines(:)
      integer :: row
      row = find_rows(keyword)
      if (row > 0) then
         allocate (lines, source=element_rows(row)%example)
      else
         allocate (lines(0))
      end if
   end function keyword_example

   !> The lists that data lines of a keyword give.
   pure function keyword_lists(keyword) result(lists)
      !> In upper case
      character(*), intent(in) :: keyword
      type(list_spec_type), allocatable :: lists(:)
      lists = pack(list_table, list_table%keyword == keyword)
   end function keyword_lists

   !> The words of a list that is separated by |.
   pure function split_values(values) result(words)
      character(*), intent(in) :: values
      character(len(values)), allocatable :: words(:)
      integer :: i, first, bar, count
      count = 1
      do i = 1, len_trim(values)
         if (values(i:i) == '|') count = count + 1
      end do
      allocate (words(count))
      first = 1
      do i = 1, count
         bar = index(values(first:), '|')
         if (bar == 0) bar = len(values) - first + 2
         words(i) = values(first:first + bar - 2)
         first = first + bar
      end do
   end function split_values

   !> 'GEAR|BELT|ROD' as 'GEAR, BELT or ROD'.
   pure function alternatives(values, mark) result(text)
      !> Words, and what is written before each
      character(*), intent(in) :: values, mark
      character(:), allocatable :: text
      integer :: i
      text = mark
      do i = 1, len(values)
         if (values(i:i) /= '|') then
            text = text//values(i:i)
         else if (index(values(i + 1:), '|') > 0) then
            text = text//', '//mark
         else
            text = text//' or '//mark
         end if
      end do
   end function alternatives

   !> Whether a word is in such a list.
   pure logical function contains_value(values, word)
      character(*), intent(in) :: values, word
      contains_value = len_trim(word) > 0 .and. index('|'//trim(values)//'|', '|'//trim(word)//'|') > 0
   end function contains_value

end module limber_deck_keywords
