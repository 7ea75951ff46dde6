!> Base type of the kinds of joints: TYPE of *JOINT. Each kind is one file of `src/elements`, which gives its word, its
!> properties, its
!> options, and its equations as sums of scalar functions. Floor: model. Source: doc/theory, eqs. (3.7)-(3.16).
module limber_model_joint_kind
   use limber_base_kinds, only: wp
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type
   use limber_model_model, only: model_type, joint_type, function_term_type, function_component, function_displacement, &
      & function_parallel, function_section_angle, function_direction, place_free, &
      & body_point, ground
   implicit none
   private
   public :: joint_kind_type, joint_kind_item_type, add_joint_kind, joint_kind, describe_joint, coincidence, across_line, &
      & alignment, &
      & rolling_wheels, right_angle

   real(wp), parameter :: right_angle = 0.5_wp*acos(-1.0_wp)

   !> A kind of joints
   type, abstract :: joint_kind_type
      !> TYPE in the deck
      character(14) :: word = ''
      !> What it demands of the place of its first point: place_at_point, ...
      integer :: place = place_free
      !> Whether it keeps the angle of the first section from the second
      logical :: keeps_angle = .false.
      !> Whether its equations need two points that are apart in the first guess
      logical :: apart = .false.
      !> Whether it fixes the rotation of the section on either side
      logical :: clamps(2) = .false.
      !> Options that it needs, separated by |
      character(28) :: needs = ''
      !> One or two lines
      character(230) :: meaning = ''
      !> Options that no other kind has
      type(option_spec_type), allocatable :: options(:)
   contains
      !> Reads its sizes, beside angle, turn and points
      procedure :: read => read_nothing
      !> Checks its bodies
      procedure :: check => check_rotation
      !> Writes its properties and equations, from its sizes
      procedure(describe_interface), deferred :: describe
   end type joint_kind_type

   !> One place of the list of kinds
   type :: joint_kind_item_type
      class(joint_kind_type), allocatable :: item
   end type joint_kind_item_type

   abstract interface
      !> Sets properties and equations of a joint, whose sizes are known.
      pure subroutine describe_interface(self, joint)
         import :: joint_kind_type, joint_type
         class(joint_kind_type), intent(in) :: self
         type(joint_type), intent(inout) :: joint
      end subroutine describe_interface
   end interface

   !> All kinds in the order of their registration
   type(joint_kind_item_type), allocatable, protected, public :: joint_kinds(:)

contains

   !> Adds a kind to the list.
   subroutine add_joint_kind(kind)
      class(joint_kind_type), intent(in) :: kind
      type(joint_kind_item_type) :: new
      allocate (new%item, source=kind)
      if (.not. allocated(kind%options)) allocate (new%item%options(0))
      if (.not. allocated(joint_kinds)) allocate (joint_kinds(0))
      joint_kinds = [joint_kinds, new]
   end subroutine add_joint_kind

   !> Index of a kind by its word in the deck; the first if there is none.
   pure integer function joint_kind(word) result(found)
      character(*), intent(in) :: word
      do found = 1, size(joint_kinds)
         if (joint_kinds(found)%item%word == word) return
      end do
      found = 1
   end function joint_kind

   !> Reads sizes: none.
   subroutine read_nothing(self, block, joint, diagnostics)
      class(joint_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
   end subroutine read_nothing

   !> Sets the properties of a joint that are those of its kind.
   pure subroutine take_kind(kind, joint)
      class(joint_kind_type), intent(in) :: kind
      type(joint_type), intent(inout) :: joint
      joint%place = kind%place
      joint%keeps_angle = kind%keeps_angle
      joint%symbol = trim(kind%word)
   end subroutine take_kind

   !> Properties and equations of a joint of a kind.
   subroutine describe_joint(word, joint)
      !> TYPE in the deck
      character(*), intent(in) :: word
      type(joint_type), intent(inout) :: joint
      associate (kind => joint_kinds(joint_kind(word))%item)
         call take_kind(kind, joint)
         call kind%describe(joint)
      end associate
   end subroutine describe_joint

   !> Reports bodies that a kind cannot connect: point masses where it fixes a rotation.
   subroutine check_rotation(self, block, model, bodies, diagnostics)
      class(joint_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      !> Indices of both bodies, or `ground`
      integer, intent(in) :: bodies(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: side
      if (.not. any(self%clamps)) return
      do side = 1, 2
         if (bodies(side) == ground) cycle
         if (model%bodies(bodies(side))%kind == body_point) call diagnostics%add(block%lines(1)%origin_of(side), &
            & "joint '"//block%name()//"' needs a body that can turn, which a point mass cannot", &
            & 'make it a *RIGID BODY, or use REVOLUTE or POINT ON LINE')
      end do
   end subroutine check_rotation

   !> Equations 1 and 2: the points coincide.
   pure function coincidence() result(terms)
      type(function_term_type) :: terms(2)
      terms(1) = function_term_type(row=1, function=function_component)
      terms(2) = function_term_type(row=2, function=function_component, angle=right_angle)
   end function coincidence

   !> Equation 1: the first point stays on a line at an angle in the second section [rad].
   pure function across_line(angle) result(term)
      real(wp), intent(in) :: angle
      type(function_term_type) :: term
      term = function_term_type(row=1, function=function_displacement, angle=angle + right_angle)
   end function across_line

   !> An equation that keeps the angle of the sections.
   pure function alignment(row) result(term)
      !> Number of the equation
      integer, intent(in) :: row
      type(function_term_type) :: term
      term = function_term_type(row=row, function=function_parallel)
   end function alignment

   !> Angles of both sections, each times its radius, less the sum of the radii times the direction from the first centre to the
   !> second;
   !> the second radius is negative if both wheels turn in the same direction, eq. (3.15).
   pure function rolling_wheels(joint) result(terms)
      type(joint_type), intent(in) :: joint
      type(function_term_type), allocatable :: terms(:)
      real(wp) :: radius(2)
      radius = joint%radius
      if (joint%same_direction) radius(2) = -radius(2)
      terms = [function_term_type(function=function_section_angle, side=1, coefficient=radius(1)), &
         & function_term_type(function=function_section_angle, side=2, coefficient=radius(2))]
      if (abs(sum(radius)) > 1.0e-12_wp*maxval(abs(radius))) &
         & terms = [terms, function_term_type(function=function_direction, coefficient=-sum(radius))]
   end function rolling_wheels

end module limber_model_joint_kind
