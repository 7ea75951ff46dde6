!> Linear couplers of joint coordinates. Sums of parts of at most two bodies, which share an equation; a coordinate along an exact
!> beam is a part by itself. Floor: multibody. Source: doc/theory, eq. (3.21).
module limber_multibody_couplers
   use limber_base_kinds, only: wp
   use limber_model_model, only: term_type, coordinate_displacement, ground
   use limber_multibody_constraint, only: constraint_type, constraint_item_type
   use limber_multibody_function_constraints, only: function_constraint_type, linear_type, most_measures, most_vectors
   use limber_multibody_joint_functions, only: joint_function_type
   use limber_multibody_marker_registry, only: registry_type
   use limber_multibody_function_sums, only: add_coordinate, add_measure, find_bodies, vector
   use limber_multibody_sliding_along_beam, only: exact_path_type
   use limber_multibody_sliding_paths, only: guessed_coordinate, new_path, slides_exactly
   implicit none
   private
   public :: add_coupler

contains

   !> A linear coupling of joint coordinates: the sum of parts of at most two bodies, eq. (3.21).
   subroutine add_coupler(system, index, item, parts)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      !> Receives the parts behind the first
      type(constraint_item_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), allocatable :: own(:)
      type(exact_path_type), allocatable :: paths(:)
      real(wp) :: sum
      integer :: i, first
      sum = 0.0_wp
      allocate (own(0), paths(0))
      do i = 1, size(system%model%joints(index)%terms)
         associate (term => system%model%joints(index)%terms(i))
            if (is_along_beam(system, term)) then
               call add_path(system, term, paths, sum)
            else
               call add_term(system, term, own, sum)
            end if
         end associate
      end do
      first = 1
      if (size(own) > 0) then
         if (.not. system%model%joints(index)%has_law) own(1)%offset(1) = sum
         call take_part(own(1), item)
      else
         first = 2
         if (.not. system%model%joints(index)%has_law) paths(1)%offset = paths(1)%offset + sum
         call take_part(paths(1), item)
      end if
      do i = 2, size(own)
         call append_part(parts, own(i))
      end do
      do i = first, size(paths)
         call append_part(parts, paths(i))
      end do

   contains

      !> The first part, which has the law.
      subroutine take_part(part, item)
         class(function_constraint_type), intent(inout) :: part
         class(constraint_type), allocatable, intent(out) :: item
         if (system%model%joints(index)%has_law) part%drive = size(system%model%drivers) &
            & + count(system%model%joints(:index)%has_law)
         call prepare(part)
         allocate (item, source=part)
      end subroutine take_part

      !> What all parts have.
      subroutine prepare(part)
         class(function_constraint_type), intent(inout) :: part
         associate (joint => system%model%joints(index))
            part%driven = joint%has_law
            part%scale = maxval(abs(joint%terms%coefficient)*merge(system%model%length, 1.0_wp, &
               & joint%terms%kind == coordinate_displacement))
            if (.not. part%scale > 0.0_wp) part%scale = 1.0_wp
         end associate
      end subroutine prepare

      !> One more part at the end of a list.
      subroutine append_part(parts, part)
         type(constraint_item_type), allocatable, intent(inout) :: parts(:)
         class(function_constraint_type), intent(inout) :: part
         type(constraint_item_type), allocatable :: longer(:)
         integer :: k
         call prepare(part)
         part%part_of = index
         allocate (longer(size(parts) + 1))
         do k = 1, size(parts)
            call move_alloc(parts(k)%item, longer(k)%item)
         end do
         allocate (longer(size(longer))%item, source=part)
         call move_alloc(longer, parts)
      end subroutine append_part

   end subroutine add_coupler

   !> Whether a term is a coordinate along an exact beam.
   pure logical function is_along_beam(system, term) result(along)
      class(registry_type), intent(in) :: system
      type(term_type), intent(in) :: term
      along = term%kind == coordinate_displacement
      if (along) along = slides_exactly(system, system%model%joints(term%of))
   end function is_along_beam

   !> Adds a coordinate along an exact beam, which is a part by itself.
   subroutine add_path(system, term, paths, sum)
      class(registry_type), intent(inout) :: system
      type(term_type), intent(in) :: term
      type(exact_path_type), allocatable, intent(inout) :: paths(:)
      !> Receives the term's value in the first guess
      real(wp), intent(inout) :: sum
      type(exact_path_type), allocatable :: longer(:)
      allocate (longer(size(paths) + 1))
      longer(:size(paths)) = paths
      associate (path => longer(size(longer)))
         path = new_path(system, system%model%joints(term%of))
         sum = sum + term%coefficient*guessed_coordinate(system, system%model%joints(term%of), path)
         path%of_coordinate = .true.
         path%factor = term%coefficient
         path%offset = term%coefficient*path%start
      end associate
      call move_alloc(longer, paths)
   end subroutine add_path

   !> Adds the measures of a joint coordinate, each to the first part that has its bodies, or room for them.
   subroutine add_term(system, term, parts, sum)
      class(registry_type), intent(inout) :: system
      type(term_type), intent(in) :: term
      type(linear_type), allocatable, intent(inout) :: parts(:)
      !> Receives the term's value in the first guess
      real(wp), intent(inout) :: sum
      type(linear_type) :: single
      integer :: k, i
      call add_coordinate(system, single, term, sum)
      do k = 1, single%count
         do i = 1, size(parts)
            if (has_room(system, parts(i), single, k)) exit
         end do
         if (i > size(parts)) call add_empty(parts)
         call move_measure(single, k, parts(i))
         call find_bodies(system, parts(i))
      end do
   end subroutine add_term

   !> One more part at the end of a list.
   subroutine add_empty(parts)
      type(linear_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), allocatable :: longer(:)
      allocate (longer(size(parts) + 1))
      longer(:size(parts)) = parts
      longer(size(longer))%rows = 1
      call move_alloc(longer, parts)
   end subroutine add_empty

   !> Whether a part can take a measure: then it is still one of two bodies.
   pure logical function has_room(system, part, single, measure) result(room)
      class(registry_type), intent(in) :: system
      type(linear_type), intent(in) :: part, single
      integer, intent(in) :: measure
      integer :: bodies(2), j, body
      room = .false.
      if (part%count == most_measures .or. part%vectors + 3 > most_vectors) return
      bodies = part%bodies
      do j = 1, 3
         if (single%measures(measure)%vectors(j) == 0) cycle
         body = system%model%points(system%marker_points(single%markers(single%measures(measure)%vectors(j))))%body
         if (body == ground .or. any(bodies == body)) cycle
         if (all(bodies /= ground)) return
         bodies(merge(1, 2, bodies(1) == ground)) = body
      end do
      room = .true.
   end function has_room

   !> Adds a measure of one constraint to another, with its coefficient in the first row.
   subroutine move_measure(from, index, to)
      type(linear_type), intent(in) :: from
      integer, intent(in) :: index
      type(linear_type), intent(inout) :: to
      type(joint_function_type) :: measure
      integer :: j
      measure = from%measures(index)
      do j = 1, 3
         if (measure%vectors(j) > 0) measure%vectors(j) = vector(to, from%markers(measure%vectors(j)))
      end do
      call add_measure(to, measure, from%coefficients(1, index), 1)
   end subroutine move_measure

end module limber_multibody_couplers
