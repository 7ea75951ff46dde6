!> Keyword table: options of bodies. Part of the table of the deck language in `limber_deck_keywords`. Floor: deck.
module limber_deck_body_options
   use limber_deck_schema, only: option_spec_type, needed, kind_name, kind_reference, kind_real, kind_positive, kind_nonnegative, &
      & kind_count, kind_counting, kind_word, kind_text, kind_yes
   implicit none
   private

   character(*), parameter :: supports = 'PINNED-ROLLER|PINNED-PINNED|CLAMPED-FREE|CLAMPED-ROLLER|CLAMPED-PINNED' &
      & //'|CLAMPED-CLAMPED|FREE-FREE'
   character(*), parameter :: of_frame = 'frame that they belong to; default the last *FRAME above'

   !> Rigid bodies and point masses
   type(option_spec_type), parameter, public :: body_options(*) = [ &
      & option_spec_type('RIGID BODY', 'NAME', kind_name, 'bodies', '', needed, 'name of the body'), &
      & option_spec_type('RIGID BODY', 'MASS', kind_nonnegative, '', 'kg', needed, 'mass'), &
      & option_spec_type('RIGID BODY', 'INERTIA', kind_nonnegative, '', &
      &    'kg m^2', '0', 'moment of inertia about the centre of mass'), &
      & option_spec_type('RIGID BODY', 'CENTRE X', kind_real, '', 'm', '0', 'x of the centre of mass in the body frame'), &
      & option_spec_type('RIGID BODY', 'CENTRE Y', kind_real, '', 'm', '0', 'y of the centre of mass in the body frame'), &
      & option_spec_type('RIGID BODY', 'X', kind_real, '', &
      &    'm', '0', 'x of the body frame at first, kept where the joints allow it'), &
      & option_spec_type('RIGID BODY', 'Y', kind_real, '', 'm', '0', 'y of the body frame at first'), &
      & option_spec_type('RIGID BODY', 'ANGLE', kind_real, '', 'rad', '0', 'angle of the body frame at first'), &
      & option_spec_type('RIGID BODY', 'VX', kind_real, '', 'm/s', '0', 'velocity along x at first'), &
      & option_spec_type('RIGID BODY', 'VY', kind_real, '', 'm/s', '0', 'velocity along y at first'), &
      & option_spec_type('RIGID BODY', 'SPIN', kind_real, '', 'rad/s', '0', 'angular velocity at first'), &
      & option_spec_type('POINT MASS', 'NAME', kind_name, 'bodies', '', needed, 'name of the point mass'), &
      & option_spec_type('POINT MASS', 'MASS', kind_nonnegative, '', 'kg', needed, 'mass'), &
      & option_spec_type('POINT MASS', 'X', kind_real, '', 'm', '0', 'x of the mass at first, kept where the joints allow it'), &
      & option_spec_type('POINT MASS', 'Y', kind_real, '', 'm', '0', 'y of the mass at first'), &
      & option_spec_type('POINT MASS', 'VX', kind_real, '', 'm/s', '0', 'velocity along x at first'), &
      & option_spec_type('POINT MASS', 'VY', kind_real, '', 'm/s', '0', 'velocity along y at first')]
   !> Beams: options for all, for exact ones, for those with modes
   type(option_spec_type), parameter, public :: beam_options(*) = [ &
      & option_spec_type('BEAM', 'NAME', kind_name, 'bodies', '', needed, 'name of the beam'), &
      & option_spec_type('BEAM', 'MATERIAL', kind_reference, 'MATERIAL', '', needed, 'its material'), &
      & option_spec_type('BEAM', 'SECTION', kind_reference, 'SECTION', '', needed, 'its cross-section'), &
      & option_spec_type('BEAM', 'LENGTH', kind_positive, '', 'm', needed, 'undeformed length'), &
      & option_spec_type('BEAM', 'GEOMETRIC', kind_word, 'RIGID|LINEAR|K_G|EXACT', &
      &    '', 'EXACT', 'rigid; K_E alone; K_E and K_G (the paper; default if modes are asked for); or exact'), &
      & option_spec_type('BEAM', 'ELEMENTS', kind_counting, '', &
      &    '', '10', 'finite elements that the modes are computed with', most=10000), &
      & option_spec_type('BEAM', 'SUPPORT', kind_word, supports, &
      &    '', 'PINNED-ROLLER', 'how the ends are held in the floating frame: defines the modes'), &
      & option_spec_type('BEAM', 'SEGMENTS', kind_counting, '', &
      &    '', '1', 'EXACT: equal pieces, each with a frame and functions of its own, welded together: ropes', &
      &    most=500), &
      & option_spec_type('BEAM', 'ORIGIN', kind_real, '', &
      &    'm', '0', 'coordinate along the beam where the floating frame has its origin'), &
      & option_spec_type('BEAM', 'X', kind_real, '', &
      &    'm', '0', 'x of the floating frame at first, kept where the joints allow it'), &
      & option_spec_type('BEAM', 'Y', kind_real, '', 'm', '0', 'y of the floating frame at first'), &
      & option_spec_type('BEAM', 'ANGLE', kind_real, '', 'rad', '0', 'angle of the floating frame at first'), &
      & option_spec_type('BEAM', 'VX', kind_real, '', 'm/s', '0', 'velocity along x at first'), &
      & option_spec_type('BEAM', 'VY', kind_real, '', 'm/s', '0', 'velocity along y at first'), &
      & option_spec_type('BEAM', 'SPIN', kind_real, '', 'rad/s', '0', 'angular velocity at first'), &
      & option_spec_type('BEAM', 'FUNCTIONS', kind_counting, '', &
      &    '', '7', 'functions of the section angle; with those of the strain 24 at most where a point slides along (SLIDING)', &
      &    most=200, models='EXACT'), &
      & option_spec_type('BEAM', 'STRAIN FUNCTIONS', kind_count, '', &
      &    '', '1', 'functions of the strain along the axis; 0: it does not stretch', most=100, models='EXACT'), &
      & option_spec_type('BEAM', 'SHEAR', kind_yes, '', &
      &    '', 'NO', 'shear and rotary inertia (Timoshenko), with as many functions of the shear as of the angle', &
      &    models='EXACT'), &
      & option_spec_type('BEAM', 'END SECTION', kind_reference, 'SECTION', &
      &    '', '', 'section at the end, or where *PROFILE begins; sizes change linearly up to it', models='EXACT'), &
      & option_spec_type('BEAM', 'CURVATURE', kind_real, '', &
      &    '1/m', '0', 'curvature of the undeformed axis, positive to the left', models='EXACT'), &
      & option_spec_type('BEAM', 'THERMAL STRAIN', kind_real, '', &
      &    '', '0', 'strain of the beam that nothing holds', models='EXACT'), &
      & option_spec_type('BEAM', 'THERMAL CURVATURE', kind_real, '', &
      &    '1/m', '0', 'curvature of the beam that nothing holds, beside CURVATURE', models='EXACT'), &
      & option_spec_type('BEAM', 'PRETENSION', kind_real, '', &
      &    'N', '0', 'tension of the undeformed beam', models='EXACT'), &
      & option_spec_type('BEAM', 'TENSION', kind_nonnegative, '', &
      &    'N', '', 'largest tension: functions for the bending near ends and loads; default: what the deck tells of it', &
      &    models='EXACT'), &
      & option_spec_type('BEAM', 'MODES', kind_count, '', &
      &    '', '6', 'number of modes: the lowest of bending and axial ones together', most=1000, models='MODES', &
      &    only='-BENDING MODES'), &
      & option_spec_type('BEAM', 'BENDING MODES', kind_count, '', &
      &    '', '', 'number of bending modes; given, it replaces MODES', most=1000, models='MODES'), &
      & option_spec_type('BEAM', 'AXIAL MODES', kind_count, '', &
      &    '', '', 'number of axial modes; without BENDING MODES, MODES is the number of bending modes', &
      &    most=1000, models='MODES'), &
      & option_spec_type('BEAM', 'CORRECTIONS', kind_yes, '', &
      &    '', 'NO', 'YES: responses to what joints, drivers and loads exert on its points, beside the modes', models='MODES'), &
      & option_spec_type('BEAM', 'GEOMETRIC ELEMENTS', kind_counting, '', &
      &    '', '2', 'elements for the geometric part, independent of ELEMENTS', most=1000, models='MODES'), &
      & option_spec_type('BEAM', 'GEOMETRIC INTEGRAL', kind_word, 'NODAL|EXACT|LINEAR', &
      &    '', 'EXACT', 'slope in an element: from its two ends, or integrated; LINEAR: and tension not constant', &
      &    models='MODES'), &
      & option_spec_type('BEAM', 'AXIAL BASIS', kind_word, 'MODES|STATIC', &
      &    '', '', 'axial modes (default if MODES or AXIAL MODES is given), or responses to forces along it and rotation', &
      &    models='MODES')]
   !> Frames and their parts
   type(option_spec_type), parameter, public :: frame_options(*) = [ &
      & option_spec_type('FRAME', 'NAME', kind_name, 'bodies', '', needed, 'name of the frame'), &
      & option_spec_type('FRAME', 'MATERIAL', kind_reference, 'MATERIAL', '', '', 'material of members that are given no other'), &
      & option_spec_type('FRAME', 'SECTION', kind_reference, 'SECTION', &
      &    '', '', 'cross-section of members that are given no other'), &
      & option_spec_type('FRAME', 'LARGE', kind_yes, '', &
      &    '', 'NO', &
      &    'YES: members are exact beams, which bend far; angle, u1, u2, rotation: of the section at the start of member 1'), &
      & option_spec_type('FRAME', 'X', kind_real, '', &
      &    'm', '0', 'x of the floating frame at first, kept where the joints allow it'), &
      & option_spec_type('FRAME', 'Y', kind_real, '', 'm', '0', 'y of the floating frame at first'), &
      & option_spec_type('FRAME', 'ANGLE', kind_real, '', 'rad', '0', 'angle of the floating frame at first'), &
      & option_spec_type('FRAME', 'VX', kind_real, '', 'm/s', '0', 'velocity along x at first'), &
      & option_spec_type('FRAME', 'VY', kind_real, '', 'm/s', '0', 'velocity along y at first'), &
      & option_spec_type('FRAME', 'SPIN', kind_real, '', 'rad/s', '0', 'angular velocity at first'), &
      & option_spec_type('FRAME', 'GEOMETRIC', kind_word, 'RIGID|LINEAR|K_G', &
      &    '', 'K_G', 'fidelity: no deflection, K_E alone, or K_E and K_G; where members bend far, LARGE=YES', models='MODES'), &
      & option_spec_type('FRAME', 'MODES', kind_count, '', &
      &    '', '', 'number of vibration modes; default 3 for each member, 6 at least, 24 at most', most=1000, models='MODES', &
      &    only='-FREQUENCY LIMIT'), &
      & option_spec_type('FRAME', 'DIVISIONS', kind_counting, &
      &    '', '', '', 'finite elements in each member; default 32, from 9 members on 256 in all, 8 at least', &
      &    most=1000, models='MODES'), &
      & option_spec_type('FRAME', 'FREQUENCY LIMIT', kind_positive, '', &
      &    'rad/s', '', 'all modes below it; given, it replaces MODES', models='MODES'), &
      & option_spec_type('FRAME', 'BASIS', kind_word, 'VIBRATION|CRAIG-BAMPTON', &
      &    '', 'VIBRATION', 'modes under the supports, or with an interface held, and its shapes: of *ATTACHMENT, else of all '// &
      &    'that acts', models='MODES'), &
      & option_spec_type('FRAME', 'CORRECTIONS', kind_yes, '', &
      &    '', '', 'responses to what joints, drivers and loads exert on it, and to its accelerations; default YES with K_G', &
      &    models='MODES'), &
      & option_spec_type('FRAME', 'FUNCTIONS', kind_counting, '', &
      &    '', '', 'functions of the angle of each member; default as *BEAM has', most=60, models='LARGE', &
      &    only='LARGE=YES'), &
      & option_spec_type('FRAME', 'STRAIN FUNCTIONS', kind_count, '', &
      &    '', '', 'functions of the strain of each member; default as *BEAM has', most=60, models='LARGE', &
      &    only='LARGE=YES'), &
      & option_spec_type('NODE', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('NODE', 'NSET', kind_text, '', '', '', 'set that these nodes join'), &
      & option_spec_type('ELEMENT', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('ELEMENT', 'ELSET', kind_text, '', '', '', 'set that these members join'), &
      & option_spec_type('ELEMENT', 'MATERIAL', kind_reference, 'MATERIAL', '', '', 'their material; default that of the frame'), &
      & option_spec_type('ELEMENT', 'SECTION', kind_reference, 'SECTION', '', '', 'their section; default that of the frame'), &
      & option_spec_type('ELEMENT', 'DIVISIONS', kind_counting, '', '', '', 'finite elements in each; default as the frame has', &
      &    most=1000), &
      & option_spec_type('NSET', 'NSET', kind_text, '', '', needed, 'name of the set'), &
      & option_spec_type('NSET', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('ELSET', 'ELSET', kind_text, '', '', needed, 'name of the set'), &
      & option_spec_type('ELSET', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('BEAM SECTION', 'ELSET', kind_text, '', '', needed, 'set of members'), &
      & option_spec_type('BEAM SECTION', 'SECTION', kind_reference, 'SECTION', '', needed, 'their cross-section'), &
      & option_spec_type('BEAM SECTION', 'MATERIAL', kind_reference, 'MATERIAL', '', '', 'their material; default as it was'), &
      & option_spec_type('BEAM SECTION', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('BOUNDARY', 'BODY', kind_reference, 'FRAME', '', '', of_frame), &
      & option_spec_type('MASS', 'BODY', kind_reference, 'FRAME|BEAM', &
      &    '', '', 'frame or beam that it belongs to; default the last one above'), &
      & option_spec_type('PROFILE', 'BODY', kind_reference, 'BEAM', &
      &    '', '', 'beam that it belongs to; default the last one above'), &
      & option_spec_type('ATTACHMENT', 'BODY', kind_reference, 'FRAME|BEAM', &
      &    '', '', 'frame or beam that it belongs to; default the last one above')]

end module limber_deck_body_options
