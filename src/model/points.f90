!> The list of named points: adding to it, and finding points and bodies that a deck refers to. Floor: model.
module limber_model_points
   use limber_base_kinds, only: wp
   use limber_base_text, only: nearest_name, lowercase
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_model_scene, only: model_type, point_type
   implicit none
   private
   public :: add_point, find_point, find_body

contains

   !> Appends a point.
   subroutine add_point(points, name, body, p0, phi, psi)
      type(point_type), allocatable, intent(inout) :: points(:)
      !> Name of the body and of the point: 'rod.middle'
      character(*), intent(in) :: name
      !> Index of the body, or `ground`
      integer, intent(in) :: body
      !> Undeformed place in the body frame (2) [length]
      real(wp), intent(in) :: p0(2)
      !> Displacement (2,n) and rotation (n) for each coordinate of a flexible body
      real(wp), intent(in), optional :: phi(:, :), psi(:)
      type(point_type), allocatable :: longer(:)
      integer :: n
      n = size(points) + 1
      allocate (longer(n))
      longer(:n - 1) = points
      longer(n)%name = name
      longer(n)%body = body
      longer(n)%p0 = p0
      if (present(phi)) then
         longer(n)%phi = phi
         longer(n)%psi = psi
      else
         allocate (longer(n)%phi(2, 0), longer(n)%psi(0))
      end if
      call move_alloc(longer, points)
   end subroutine add_point

   !> Index of the point that a deck names `object.point`, or `object` for the origin of its frame; 0 with a complaint if
   !> there is none.
   integer function find_point(model, name, origin, diagnostics) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      !> Where it is named
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: whole, owner
      character(64), allocatable :: own(:), all(:)
      integer :: i, near
      whole = lowercase(name)
      if (index(whole, '.') == 0) whole = whole//'.origin'
      do found = 1, size(model%points)
         if (model%points(found)%name == whole) return
      end do
      found = 0
      owner = whole(:index(whole, '.'))
      allocate (own(0), all(0))
      do i = 1, size(model%points)
         all = [character(64) :: all, model%points(i)%name]
         if (index(model%points(i)%name, owner) == 1) own = [character(64) :: own, model%points(i)%name]
      end do
      if (size(own) > 0) then
         call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", 'valid: '//listed(own))
      else
         near = nearest_name(whole, all)
         if (near > 0) then
            call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", "did you mean '"//trim(all(near))//"'?")
         else
            call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", &
               & 'no body or ground point of this name is defined')
         end if
      end if
   end function find_point

   !> Index of a body; 0 if there is none of this name.
   pure integer function find_body(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      do found = size(model%bodies), 1, -1
         if (model%bodies(found)%name == name) return
      end do
   end function find_body

   !> Names separated by commas.
   pure function listed(names) result(text)
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: i
      text = trim(names(1))
      do i = 2, size(names)
         text = text//', '//trim(names(i))
      end do
   end function listed

end module limber_model_points
