!> Rigid bodies, point masses and their named points. Floor: model.
module limber_model_bodies
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_beam_beam_mesh, only: field_bytes
   use limber_beam_reduced_body, only: rigid_reduced, bytes_of
   use limber_model_lists, only: append
   use limber_model_points, only: add_point, enter_name, find_named
   use limber_model_model, only: model_type, body_type, point_type, body_point, body_rigid
   implicit none
   private
   public :: add_rigid_body, add_point_mass, add_points, new_body, append_body, is_new_point, memory_of, warn_of_rounding

contains

   !> A body with its initial guess of position and velocity from the deck.
   function new_body(block, kind) result(body)
      type(block_type), intent(in) :: block
      integer, intent(in) :: kind
      type(body_type) :: body
      body%name = block%name()
      body%kind = kind
      body%position = [block%real('X'), block%real('Y')]
      body%velocity = [block%real('VX'), block%real('VY')]
      body%given = [block%given('X'), block%given('Y'), .false., block%given('VX'), block%given('VY'), .false.]
      if (kind == body_point) return
      body%angle = block%real('ANGLE')
      body%spin = block%real('SPIN')
      body%given(3) = block%given('ANGLE')
      body%given(6) = block%given('SPIN')
   end function new_body

   !> Adds a rigid body with its points.
   subroutine add_rigid_body(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(body_type) :: body
      real(wp) :: centre(2)
      integer :: index
      body = new_body(block, body_rigid)
      centre = [block%real('CENTRE X'), block%real('CENTRE Y')]
      body%reduced = rigid_reduced(block%real('MASS'), block%real('INERTIA'), centre)
      if (block%real('INERTIA') > 0.0_wp .and. .not. block%real('MASS') > 0.0_wp) call diagnostics%warn( &
         & block%origin_of('INERTIA'), "body '"//body%name//"' has an inertia but no mass")
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
      call add_point(model, body%name//'.centre', index, centre)
      call add_points(block, body%name, index, model, diagnostics)
      model%bodies(index)%size = extent(model, index)
   end subroutine add_rigid_body

   !> Adds a point mass; its only point is `origin`.
   subroutine add_point_mass(block, model)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(body_type) :: body
      integer :: index
      body = new_body(block, body_point)
      body%reduced = rigid_reduced(block%real('MASS'), 0.0_wp, [0.0_wp, 0.0_wp])
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
   end subroutine add_point_mass

   !> Appends a body.
   subroutine append_body(model, body, index)
      type(model_type), intent(inout) :: model
      type(body_type), intent(in) :: body
      !> Its index
      integer, intent(out) :: index
      call append(model%bodies, model%counts%bodies, body)
      index = model%counts%bodies
      model%bytes = model%bytes + memory_of(body)
      call enter_name(model, 'body', body%name, index)
   end subroutine append_body

   !> Memory of the constants and shapes of a body [bytes].
   pure integer(long) function memory_of(body) result(bytes)
      type(body_type), intent(in) :: body
      bytes = bytes_of(body%reduced) + field_bytes(body%field)
      if (allocated(body%shape)) bytes = bytes + 8*size(body%shape, kind=long)
   end function memory_of

   !> Adds named points of the ground or of a rigid body. Each data line is `name, x, y`.
   subroutine add_points(block, owner, index, model, diagnostics)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: owner
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            if (.not. is_new_point(model, owner//'.'//line%text(1), line%origin_of(1), diagnostics)) cycle
            call add_point(model, owner//'.'//line%text(1), index, [line%number(2), line%number(3)])
         end associate
      end do
   end subroutine add_points

   !> Whether a point name is new. Adds an error for the name of a standard point, such as 'origin'. Other repeated names were
   !> reported by the reader.
   logical function is_new_point(model, name, origin, diagnostics)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(6), parameter :: own_names(5) = [character(6) :: 'origin', 'centre', 'start', 'middle', 'end']
      is_new_point = find_named(model, 'point', name) == 0
      if (is_new_point) return
      if (any(own_names == name(index(name, '.') + 1:))) call diagnostics%add(origin, &
         & "point '"//name//"' is there without being defined", 'choose another name')
   end function is_new_point

   !> Warns of round-off in the stiffness of very short elements: its relative effect on the lowest frequency, eq. (2.3).
   subroutine warn_of_rounding(slenderness, origin, what, diagnostics)
      !> Length of the body divided by the length of its shortest element
      real(wp), intent(in) :: slenderness
      type(origin_type), intent(in) :: origin
      !> 'beam ...'
      character(*), intent(in) :: what
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: clamped_free = 12.36_wp, allowed = 1.0e-4_wp
      real(wp) :: part
      part = 0.5_wp*epsilon(part)*slenderness**4/clamped_free
      if (part > allowed) call diagnostics%warn(origin, what//': round-off of elements that are so short makes its lowest'// &
         & ' frequency wrong by a part of about '//as_text(part, 1), 'a hundred elements along it are enough for most modes')
   end subroutine warn_of_rounding

   !> Largest distance between two points of the last body [length]. For many points only the extreme points in some directions are
   !> compared; the result is then too small by at most 0.5 %.
   pure real(wp) function extent(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer, parameter :: directions = 32
      real(wp), parameter :: pi = acos(-1.0_wp)
      integer :: chosen(directions), first, i, j, count
      first = model%counts%points
      do while (first > 1)
         if (model%points(first - 1)%body /= body) exit
         first = first - 1
      end do
      count = min(model%counts%points - first + 1, directions)
      chosen = [(first + i - 1, i=1, directions)]
      if (model%counts%points - first + 1 > directions) then
         do i = 1, directions
            chosen(i) = extreme(model%points(first:model%counts%points), i*(2.0_wp*pi/directions)) + first - 1
         end do
      end if
      extent = 0.0_wp
      do i = 1, count
         do j = 1, i - 1
            extent = max(extent, norm2(model%points(chosen(i))%p0 - model%points(chosen(j))%p0))
         end do
      end do
   end function extent

   !> Index of the farthest point in a direction [rad].
   pure integer function extreme(points, direction)
      type(point_type), intent(in) :: points(:)
      real(wp), intent(in) :: direction
      real(wp) :: farthest, far, along(2)
      integer :: i
      along = [cos(direction), sin(direction)]
      extreme = 1
      farthest = dot_product(along, points(1)%p0)
      do i = 2, size(points)
         far = dot_product(along, points(i)%p0)
         if (far > farthest) then
            farthest = far
            extreme = i
         end if
      end do
   end function extreme

end module limber_model_bodies
